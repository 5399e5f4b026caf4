"""Where results that take long are kept between runs."""

from __future__ import annotations

import os
from pathlib import Path


def cache_directory(chosen: str | Path | None = None) -> Path:
    """Return ``chosen``, else the directory in the variable ``TFRA_CACHE``, else ``~/.cache/tfra``; absolute."""
    return Path(chosen or os.environ.get("TFRA_CACHE") or Path.home() / ".cache" / "tfra").absolute()
