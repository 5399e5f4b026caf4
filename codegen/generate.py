"""``tfra generate``: a directory with the files of a back end."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tfra.codegen.backend import find_backend
from tfra.codegen.package.contents import Part
from tfra.model.fixed.design import Design
from tfra.runtime.outputs import output_directory


def generate(
    design: Design, directory: Path, inputs: Sequence[Path] = (), part: Part | None = None, backend: str = "verilog"
) -> dict[str, Any]:
    """Write all files of ``design``, which comes from the files ``inputs``, into ``directory``; return the sidecar.

    The files are those of the ``backend``, and with a ``part`` those of its package for projects of others.  The same
    design gives the same bytes.

    Raises as the back end's ``files``, and ``InputError`` for a directory that can't be written, or a name that a
    package can't have; all leave the directory as it was.
    """
    chosen = find_backend(backend)
    with output_directory(directory, "generate", inputs) as fresh:
        files = chosen.files(design)
        if part:
            files |= chosen.package(design, files, part)
        for name, text in files.items():
            (fresh / name).parent.mkdir(parents=True, exist_ok=True)
            (fresh / name).write_text(text, encoding="utf-8", newline="\n")
            if name.endswith(".sh"):
                (fresh / name).chmod(0o755)
    facts: dict[str, Any] = json.loads(files[f"{design.name}.json"])
    return facts
