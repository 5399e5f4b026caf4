"""C simulation of HLS cores: g++ with the headers that the hls4ml package has."""

import subprocess
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from tests.codegen.package.made import write

FLAGS = ("-std=c++14", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-unknown-pragmas", "-Wno-uninitialized")
"""Of the headers' own words g++ thinks that they are not initialised."""


def headers() -> Path:
    """Folder of ap_int.h and hls_stream.h."""
    found = find_spec("hls4ml")
    assert found, "pip install hls4ml==1.3.0"
    assert found.origin
    return Path(found.origin).parent / "templates/vivado/ap_types"


def built(folder: Path, texts: Mapping[str, str], name: str, test: str | None = None) -> Path:
    """The program of the core ``name``, whose files are ``texts``, with its testbench or another ``test``."""
    write(folder, texts)
    test = test or f"{name}_test.cpp"
    command = ["g++", *FLAGS, "-isystem", str(headers()), "-o", "csim", f"firmware/{name}.cpp", test]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]
    return folder / "csim"


def said(program: Path, status: int = 0) -> str:
    """What ``program`` prints; it must end with ``status``."""
    done = subprocess.run([program], cwd=program.parent, capture_output=True, text=True, check=False)
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout
