"""Results as messages of an MCAP file, which Foxglove and rerun read: one a frame, in JSON with its schema."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

LATEST = 1.8e10
"""Seconds since 1970 that do not fit any more."""

_NUMBER = {"type": ["number", "null"]}

_FORCE = {
    "force_n": {"type": "object", "properties": {axis: _NUMBER for axis in "xyz"}},
    "mu": _NUMBER,
    "phi_deg": _NUMBER,
    "uncertainty_n": _NUMBER,
    "status": {"type": "array", "items": {"type": "string"}},
}

_PLANE = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}, "description": "row by row"}

FORCES = {
    "title": "tfra.Forces",
    "description": "The forces of a frame; in N, angles in degrees, times in s.",
    "type": "object",
    "properties": {
        "frame": {"type": "integer"},
        **_FORCE,
        "taxels_n": {"type": "object", "properties": {axis: _PLANE for axis in "xyz"}},
    },
}
"""JSON schema of a message of an array; ``taxels_n`` is missing where a core gives the resultant alone."""

CONTACTS = {
    "title": "tfra.Contacts",
    "description": "The contacts of a frame; lengths in mm, forces in N, angles in degrees, times in s.",
    "type": "object",
    "properties": {
        "frame": {"type": "integer"},
        "dropped": {"type": "integer", "description": "peaks beyond as many contacts as there may be"},
        "contacts": {
            "type": "array",
            "items": {
                "type": "object",
                "properties": {
                    "track": {"type": "integer", "description": "a number that a contact keeps over frames"},
                    "x_mm": {"type": "number"},
                    "y_mm": {"type": "number"},
                    "taxels": {"type": "integer"},
                    **_FORCE,
                },
            },
        },
    },
}
"""The same of a skin."""


def write_messages(
    path: Path, described: dict[str, Any], messages: Iterable[dict[str, Any]], seconds: Iterable[float]
) -> None:
    """Write ``messages``, which the schema describes, at their times to a file that does not exist.

    Their topic is the file's name.  Equal messages give equal bytes.
    """
    from mcap.writer import Writer

    with open(path, "xb") as stream:
        writer = Writer(stream)
        writer.start(library="tfra")
        schema = writer.register_schema(described["title"], "jsonschema", json.dumps(described).encode())
        channel = writer.register_channel(f"/{path.stem}", "json", schema)
        for message, time in zip(messages, seconds, strict=True):
            nanoseconds = round(1e9 * time)
            content = json.dumps(message, allow_nan=False).encode()
            writer.add_message(channel, nanoseconds, content, nanoseconds)
        writer.finish()  # type: ignore[no-untyped-call]
