"""Errors of pydantic and of the model in the terms of a CONFIG file."""

import difflib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError

from tfra.codegen.config.schema import FORMS, Document, Section
from tfra.codegen.config.write import KEYS
from tfra.runtime.errors import InputError, quoted

_NEEDED = {
    "int_type": "a whole number is needed",
    "float_type": "a number is needed",
    "bool_type": "true or false is needed",
    "finite_number": "a finite number is needed",
    "string_type": "a text in quotes is needed",
    "string_pattern_mismatch": "a letter, then at most 62 letters, digits and underscores are needed",
    "list_type": "an array of tables, [[{key}]], is needed",
    "model_type": "a table is needed",
    "dict_type": "a table is needed",
    "literal_error": "{expected} is needed",
    "greater_than_equal": "{ge:g} or more is needed",
    "less_than_equal": "{le:g} or less is needed",
    "string_too_short": "a name is needed",
    "too_short": "at least one value is needed",
    "too_long": "at most {max_length} values are supported",
}


@contextmanager
def blame(file: Path, section: str) -> Iterator[None]:
    """Turn the model's ``ValueError("field: reason")`` into an ``InputError`` with the file's key."""
    try:
        yield
    except ValueError as error:
        field, _, reason = str(error).partition(": ")
        *sections, field = [*([section] if section else []), *field.split(".")]
        raise InputError(file, ".".join([*sections, KEYS.get(field, field)]), reason) from None


def complaint(error: ValidationError, document: type[Section] = Document) -> tuple[str, str]:
    """Return (key, reason) of the most helpful error: an unknown key often explains a missing one.

    ``document`` is the model that the file was read as.
    """
    findings: list[Any] = error.errors(include_url=False)
    finding = next((f for f in findings if f["type"] == "extra_forbidden"), findings[0])
    location = tuple(part for part in finding["loc"] if part not in FORMS)
    return _key(location), _reason(finding, location, document)


def _key(location: tuple[int | str, ...]) -> str:
    """Turn ``("contact", 0, "mu")`` into ``contact#1.mu``, counting from one."""
    parts = (f"#{part + 1}" if isinstance(part, int) else f".{part}" for part in location)
    return "".join(parts).removeprefix(".")


def _reason(finding: Any, location: tuple[int | str, ...], document: type[Section]) -> str:
    if finding["type"] == "missing":
        return "is missing"
    if finding["type"] == "extra_forbidden":
        fields = _section(location[:-1], document).model_fields
        known = [field.alias or name for name, field in fields.items()]
        nearest = difflib.get_close_matches(str(location[-1])[:60], known, n=1, cutoff=0)[0]
        return f'unknown key, the nearest valid key is "{nearest}"'
    needed = _NEEDED.get(finding["type"], finding["msg"])
    tables = ".".join(part for part in location if isinstance(part, str))
    return f"{needed.format(**finding.get('ctx', {}), key=tables)}, got {quoted(finding['input'])}"


def _section(location: tuple[int | str, ...], model: type[Section]) -> type[Section]:
    """Return the model of the table at ``location`` of a document."""
    for part in location:
        if isinstance(part, str):
            model = next(_models_in(model.model_fields[part].annotation))
    return model


def _models_in(annotation: Any) -> Iterator[type[Section]]:
    if isinstance(annotation, type) and issubclass(annotation, Section):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)
