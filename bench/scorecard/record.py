"""Records of parts of a line, each kept from the moment it is there, since a measurement may be cut."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tfra.runtime.store import cached_step


def kept(name: str, key: str, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What ``make`` returns, plain JSON; from the cache if it was made for this ``key``, the hash of all behind it."""
    with tempfile.TemporaryDirectory() as folder:
        return cached_step(f"scorecard-{name}", key, Path(folder), make)[0]
