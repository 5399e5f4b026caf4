"""Names of results: hashes of all that they are made from, the sources of packages included."""

import hashlib
from pathlib import Path
from types import ModuleType

_SOURCES = (".py", ".v", ".json", ".toml")


def digest(*parts: str) -> str:
    """Return a short hash of texts, for the name of a result made from them."""
    hashed = hashlib.sha256()
    for part in parts:
        hashed.update(f"{len(part)} {part}".encode())
    return hashed.hexdigest()[:16]


def sources(*packages: ModuleType) -> list[str]:
    """Return the text of every file of ``packages`` that determines their output, Verilog and tables included.

    Temporary files of an editor may be in the folder, and need not be text.
    """
    files = (file for package in packages for file in Path(package.__path__[0]).rglob("*"))
    return [file.read_text() for file in sorted(files) if file.suffix in _SOURCES]
