"""All formats: each file of this folder has a ``FORMAT``, so a new format is a new file here."""

from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from tfra.recordings.format import Format


@cache
def formats() -> tuple[Format, ...]:
    """Return the formats of this folder's files."""
    return tuple(import_module(f"{__name__}.{module.name}").FORMAT for module in iter_modules(__path__))


def format_of(path: Path) -> Format | None:
    """Return the format of the file or folder at ``path``; None if no format accepts its name."""
    return next((each for each in formats() if each.accepts(path)), None)


def suffixes() -> list[str]:
    """Return the suffixes of all formats."""
    return sorted(suffix for each in formats() for suffix in each.suffixes)


def table_formats() -> dict[str, Format]:
    """Return the formats that results can be written in, by the first of their suffixes."""
    found = {each.suffixes[0]: each for each in formats() if each.write_table}
    return {suffix: found[suffix] for suffix in sorted(found)}
