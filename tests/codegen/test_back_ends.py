"""Every back end keeps the seam's promises, and ``generate`` takes it by its name."""

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from tests.codegen.package.made import PART, SERIAL_CORE
from tfra.codegen.generate import BACKENDS, Backend, generate
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.sidecar.schema import schema
from tfra.runtime.errors import InputError

ECHO = Backend(
    lambda design: {f"{design.name}.json": json.dumps({"name": design.name})},
    lambda design, files, part: {"folder/run.sh": f"{part.target.name} {sorted(files)}"},
)


@pytest.mark.parametrize("backend", BACKENDS.values(), ids=BACKENDS.keys())
def test_files_of_a_back_end(backend: Backend) -> None:
    """Names stay in the directory, and the common sidecar is among them."""
    files = backend.files(SERIAL_CORE)
    assert not any(Path(name).is_absolute() or ".." in Path(name).parts for name in files)
    facts = json.loads(files[f"{SERIAL_CORE.name}.json"])
    jsonschema.validate(facts, json.loads(schema()))
    assert facts["configuration_sha256"] == sidecar(SERIAL_CORE)["configuration_sha256"]


def test_generate_takes_a_back_end_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BACKENDS, "echo", ECHO)
    assert generate(replace(SERIAL_CORE, name="one"), tmp_path / "one", backend="echo") == {"name": "one"}
    assert (tmp_path / "one" / "one.json").exists()
    generate(SERIAL_CORE, tmp_path / "two", part=PART, backend="echo")
    script = tmp_path / "two" / "folder" / "run.sh"
    assert script.read_text() == f"{PART.target.name} ['tiny.json']"
    assert script.stat().st_mode & 0o111


def test_an_unknown_back_end_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^backend: vhdl: one of verilog, c, hls is needed$"):
        generate(SERIAL_CORE, tmp_path / "core", backend="vhdl")
    assert not (tmp_path / "core").exists()
