"""Optional packages: the extra that installs each is told before one is missed."""

from importlib.util import find_spec
from pathlib import Path

from tfra.runtime.errors import InputError

_MODULES = {"pyserial": "serial", "systemrdl-compiler": "systemrdl"}
"""Modules whose names differ from those of their packages by more than hyphens."""


def require(where: str | Path, extra: str, *packages: str) -> None:
    """Raise ``InputError`` about ``where`` for the first of ``packages`` that is missing; ``extra`` installs it."""
    for package in packages:
        if find_spec(_MODULES.get(package, package.replace("-", "_"))) is None:
            raise InputError(where, "", f"{package} is missing, please run: pip install 'tfra[{extra}]'")
