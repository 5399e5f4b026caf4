"""A cache of tool runs: the same program runs once on the same input.

An interrupted run continues after the last finished tool.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tfra.runtime.cache import cache_directory, kept

_FOUND = "found"
"""The entry that holds what the step returned."""


def once(name: str, key: str, directory: Path, step: Callable[[], dict[str, Any]]) -> tuple[dict[str, Any], bool]:
    """Return the result of ``step``, plain JSON types, and whether it was in the cache with the step's new files.

    ``name`` and ``key`` identify the step; its files are in ``directory`` afterwards, in either case.
    """
    made: list[dict[str, Any]] = []

    def make() -> dict[str, bytes]:
        before = _files(directory)
        made.append(step())
        new = {file: (directory / file).read_bytes() for file in sorted(_files(directory) - before)}
        content = {_FOUND: json.dumps(made[0]).encode(), **new}
        return {file: zlib.compress(each, 1) for file, each in content.items()}

    packed = kept(cache_directory() / f"{name}-{key}", make)
    if made:
        return made[0], False
    files = {file: zlib.decompress(content) for file, content in packed.items()}
    found: dict[str, Any] = json.loads(files.pop(_FOUND))
    for file, content in files.items():
        (directory / file).write_bytes(content)
    return found, True


def _files(directory: Path) -> set[str]:
    return {path.name for path in directory.iterdir()}
