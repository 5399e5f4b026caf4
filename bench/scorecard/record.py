"""Records of parts of a line, each kept from the moment it is there, since a measurement may be cut."""

import json
from collections.abc import Callable
from typing import Any

from tfra.runtime.store import cache_directory, cached


def kept(name: str, key: str, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What ``make`` returns, plain JSON; from the cache if it was made for this ``key``, the hash of all behind it."""
    files = cached(cache_directory() / f"{name}-{key}", lambda: {"record.json": json.dumps(make()).encode()})
    found: dict[str, Any] = json.loads(files["record.json"])
    return found
