"""The working folder of a long command, which goes on there after any interruption.

The folder belongs to one kind of work, one state of the sources, since others might compute different results, and one
process at a time.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

from tfra.runtime.errors import InputError
from tfra.runtime.inputs import opened
from tfra.runtime.pieces import put
from tfra.runtime.scratch import locked, writing


@contextmanager
def held(folder: Path, kind: str, sources: str) -> Iterator[None]:
    """Hold ``folder``, which is made if it is missing, for the block; ``sources`` is a hash.

    Raises ``InputError`` where it has other contents, is of other sources, or is held by another run.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        empty = not os.listdir(folder)
    if empty:
        content = {"generator": f"tfra {version('tfra')}", "sources": sources}
        put(folder, f"{kind}.json", (json.dumps(content, indent=1) + "\n").encode())
    _require_own(folder, kind, sources)
    with locked(folder, kind, wait=False) as free:
        if not free:
            raise InputError(folder, "", "is held by another run: wait for it, or choose another folder by --work")
        yield


def _require_own(folder: Path, kind: str, sources: str) -> None:
    try:
        with opened(folder / f"{kind}.json") as stream:
            about = json.loads(stream.read())
        generator, its = str(about["generator"]), about["sources"]
    except (InputError, ValueError, LookupError, TypeError, RecursionError):
        reason = f"is not the folder of a {kind}: choose another one by --work"
        raise InputError(folder, "", reason) from None
    if its != sources:
        reason = f"has work of {generator} with other sources, which is kept: choose another one by --work"
        raise InputError(folder, "", reason)
