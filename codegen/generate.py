"""``tfra generate``: a directory with the files of a back end, which turns a design into those of a target language.

A new back end takes a folder ``codegen/NAME/`` with a function ``files``, an entry in ``BACKENDS`` and its test.  Every
back end's files include the sidecar ``NAME.json`` of :mod:`tfra.codegen.sidecar.build`.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tfra.codegen.c.files import files as c
from tfra.codegen.c.skin import skin_files
from tfra.codegen.hls.files import files as hls
from tfra.codegen.package.contents import Part
from tfra.codegen.package.folder import package
from tfra.codegen.verilog.files import files as verilog
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin
from tfra.runtime.errors import InputError
from tfra.runtime.outputs import output_directory

Files = dict[str, str]
"""Text of every file by its name, with folders."""


@dataclass(frozen=True)
class Backend:
    """A language that designs are written in."""

    files: Callable[[Design], Files]
    """The files of a design, the same for the same design; raises ``ValueError`` for one that can't be built."""
    package: Callable[[Design | Skin, Mapping[str, str], Part], Files] | None = None
    """Further files around those given, for projects with the device; None where there are none."""
    skin: Callable[[Skin], Files] | None = None
    """Those of a skin; None where there are none."""


BACKENDS = {"verilog": Backend(verilog, package, verilog), "c": Backend(c, skin=skin_files), "hls": Backend(hls)}


def generate(
    array: Design | Skin,
    directory: Path,
    inputs: Sequence[Path] = (),
    part: Part | None = None,
    backend: str = "verilog",
) -> dict[str, Any]:
    """Write all files of a design or a skin, which comes from the files ``inputs``, into ``directory``.

    Returns the sidecar.  The files are those of the ``backend``, and with a ``part`` those of its package for projects
    of others.  The same design gives the same bytes.

    Raises as the back end's ``files``, and ``InputError`` for a directory that can't be written, or a name that a
    package can't have; all leave the directory as it was.
    """
    if backend not in BACKENDS:
        raise InputError("backend", backend, f"one of {', '.join(BACKENDS)} is needed")
    chosen = BACKENDS[backend]
    with output_directory(directory, "generate", inputs) as fresh:
        if not isinstance(array, Skin):
            files = chosen.files(array)
        elif chosen.skin:
            files = chosen.skin(array)
        else:
            raise InputError(backend, "window", "no C++ for HLS tools can be made of a skin")
        if part and chosen.package:
            files |= chosen.package(array, files, part)
        for name, text in files.items():
            (fresh / name).parent.mkdir(parents=True, exist_ok=True)
            (fresh / name).write_text(text, encoding="utf-8", newline="\n")
            if name.endswith(".sh"):
                (fresh / name).chmod(0o755)
    facts: dict[str, Any] = json.loads(files[f"{array.name}.json"])
    return facts
