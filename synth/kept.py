"""A cache of tool runs: the same program runs once on the same input.

An interrupted run continues after the last finished tool.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tfra.model.cache import cache_directory, kept

_FOUND = "found"
"""The entry that holds what the step returned."""


def once(name: str, key: str, directory: Path, step: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return the result of ``step``, plain JSON types; caches it and the new files in ``directory``.

    ``name`` and ``key`` identify the step.
    """

    def make() -> dict[str, bytes]:
        before = _files(directory)
        found = {_FOUND: json.dumps(step()).encode()}
        made = {file: (directory / file).read_bytes() for file in sorted(_files(directory) - before)}
        return {file: zlib.compress(content, 1) for file, content in {**found, **made}.items()}

    packed = kept(cache_directory() / f"{name}-{key}", make)
    files = {file: zlib.decompress(content) for file, content in packed.items()}
    found: dict[str, Any] = json.loads(files.pop(_FOUND))
    for file, content in files.items():
        (directory / file).write_bytes(content)
    return found


def _files(directory: Path) -> set[str]:
    return {path.name for path in directory.iterdir()}
