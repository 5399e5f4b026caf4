"""The contacts of a CONFIG file: loads on the cover, one in a frame, or several on a skin."""

import math
from collections.abc import Iterator
from fractions import Fraction
from itertools import chain
from pathlib import Path

from tfra.codegen.config.complaints import blame
from tfra.codegen.config.schema import ContactSection, Document, SensorSection, exact, metres
from tfra.model.cover.contact import Contact
from tfra.runtime.errors import InputError

MOST_CONTACTS = 100_000
"""Contacts of a file, each direction counted."""


def read_contacts(file: Path, document: Document) -> tuple[tuple[Contact, ...], int]:
    """All contacts in the order of their frames, and how many each frame has; raises ``InputError``."""
    count, tables = 0, []
    for number, section in enumerate(document.contact, 1):
        with blame(file, f"contact#{number}"):
            directions = section.directions()
            count += len(directions)
            if count > MOST_CONTACTS:
                raise ValueError(f"phi_deg: at most {MOST_CONTACTS} directions of all contacts are supported")
            tables.append(list(_loads(section, document.sensor, directions)))
    if document.window is None:
        return tuple(chain(*tables)), 1
    return _together(file, tables), max(1, len(tables))


def _loads(section: ContactSection, sensor: SensorSection, directions: list[float]) -> Iterator[Contact]:
    center_x = _center("x", section, sensor.columns, sensor.pitch_x_mm)
    center_y = _center("y", section, sensor.rows, sensor.pitch_y_mm)
    for degrees in directions:
        yield Contact(
            shape=section.shape,  # type: ignore[arg-type]  # names are converted and checked there
            center_x=metres(center_x),
            center_y=metres(center_y),
            half_x=metres(exact(section.half_x_mm)),
            half_y=metres(exact(section.half_y_mm)),
            normal_force=section.force_n,
            mu=section.mu,
            phi=math.radians(degrees),
        )


def _together(file: Path, tables: list[list[Contact]]) -> tuple[Contact, ...]:
    """Contacts that act at the same time, frame by frame; one that has a single direction keeps it."""
    frames = max((len(table) for table in tables), default=0)
    for number, table in enumerate(tables, 1):
        if len(table) not in (1, frames):
            reason = f"contacts of a skin act together: 1 or {frames} directions are needed, got {len(table)}"
            raise InputError(file, f"contact#{number}.phi_deg", reason)
    if frames * len(tables) > MOST_CONTACTS:
        raise InputError(file, "contact", f"at most {MOST_CONTACTS} contacts of all frames are supported")
    return tuple(table[frame % len(table)] for frame in range(frames) for table in tables)


def _center(axis: str, section: ContactSection, count: int, pitch_mm: float) -> Fraction:
    """Return the centre along ``axis`` in mm; raises ``ValueError`` when the footprint leaves the block."""
    given = getattr(section, f"center_{axis}_mm")
    half, pitch = exact(getattr(section, f"half_{axis}_mm")), exact(pitch_mm)
    center = (count - 1) * pitch / 2 if given is None else exact(given)
    low, high = -pitch / 2, (count - Fraction(1, 2)) * pitch
    if center - half < low or center + half > high:
        key = f"half_{axis}_mm" if 2 * half > high - low else f"center_{axis}_mm"
        reach, block = _span(center - half, center + half), _span(low, high)
        raise ValueError(f"{key}: the footprint {reach} leaves the block {block}")
    return center


def _span(low: Fraction, high: Fraction) -> str:
    return f"from {float(low):g} to {float(high):g} mm"
