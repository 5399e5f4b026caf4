"""The files of a calibration: TOML for commands, and the tables of a core's front end for the drivers."""

import json
from pathlib import Path
from typing import Any

from tfra.calibrate.calibrated import Calibrated, short
from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.front_end import Settings, Tables
from tfra.model.fixed.repair import ONE, targets
from tfra.recordings.calibration import Calibration, File, written
from tfra.recordings.front_end import FrontEnd

TOML = "cal.toml"

SETTINGS = ("word_bits", "is_unsigned", "invert")
"""Those of the front end that follow from a calibration; the others are the user's."""

_HEADER = """/* The front end of a core after a calibration: call tfra_calibrate() while the core is stopped. */
#ifndef TFRA_CALIBRATION_H
#define TFRA_CALIBRATION_H

#include "tfra_driver.h"

{arrays}

/** Writes offsets, gains, repairs and the form of the words; all other settings stay. */
static inline tfra_error_t tfra_calibrate(tfra_device_t *device)
{{
    tfra_front_end_t settings;
    tfra_error_t error = tfra_get_front_end(device, &settings);
    settings.word_bits = {word_bits};
    settings.is_unsigned = {is_unsigned};
    settings.invert = {invert};
    if (error == TFRA_OK)
        error = tfra_set_front_end(device, &settings);
    if (error == TFRA_OK)
        error = tfra_set_offsets(device, 0, tfra_calibrated_offsets, {taxels});
    if (error == TFRA_OK)
        error = tfra_set_gains(device, 0, tfra_calibrated_gains, {taxels});
    if (error == TFRA_OK)
        error = tfra_set_repairs(device, tfra_calibrated_repairs, {repairs});
    return error;
}}

#endif
"""


def write(found: Calibrated, folder: Path) -> None:
    """Write ``cal.toml`` and, if a core can have them, ``front_end.json`` and ``front_end.h`` into ``folder``."""
    (folder / TOML).write_text(_toml(found), encoding="utf-8")
    known = Calibration(found.gain, found.rest, found.dead)
    front_end = FrontEnd(found.array, found.given, None, known)
    if not front_end.is_of_a_core:
        return
    settings, tables = front_end.settings, front_end.tables
    (folder / "front_end.json").write_text(as_json(settings, tables), encoding="utf-8")
    (folder / "front_end.h").write_text(header(settings, tables), encoding="utf-8")


def _toml(found: Calibrated) -> str:
    given = found.given
    return written(
        File(
            form="tfra-calibration-1",
            order=given.order,
            flip_x=given.flip_x,
            flip_y=given.flip_y,
            compression=given.compression,
            gain=_rows(found.gain),
            gain_error=_rows(found.gain_error),
            rest=_rows(found.rest),
            noise=_rows(found.noise),
            dead=[list(place) for place in found.dead_places],
            cover=found.cover,
        )
    )


def _rows(table: Floats) -> list[list[float]]:
    return [[short(value) for value in row] for row in table]


def as_json(settings: Settings, tables: Tables) -> str:
    """The tables for the Python driver's ``Core.calibrate``."""
    repairs: dict[str, Any] = {
        str(target): {str(source): weight / ONE for source, weight in zip(sources, weights.tolist(), strict=True)}
        for target, sources, weights in targets(tables.repairs)
    }
    content = {
        "settings": {name: getattr(settings, name) for name in SETTINGS},
        "offsets": tables.offsets.tolist(),
        "gains": tables.gains.tolist(),
        "repairs": repairs,
    }
    return json.dumps(content) + "\n"


def header(settings: Settings, tables: Tables) -> str:
    """The header with ``tfra_calibrate()`` for the C driver."""
    arrays = (("int32_t", "offsets"), ("uint32_t", "gains"), ("uint32_t", "repairs"))
    return _HEADER.format(
        arrays="\n".join(_array(kind, name, getattr(tables, name)) for kind, name in arrays),
        taxels=len(tables.gains),
        repairs=len(tables.repairs),
        **{name: str(getattr(settings, name)).lower() for name in SETTINGS},
    )


def _array(kind: str, name: str, words: Ints) -> str:
    """A constant array of C; it has a word if there are none, since C has no empty arrays."""
    suffix = "u" if kind.startswith("u") else ""
    values = ", ".join(f"{word}{suffix}" for word in words.tolist()) or "0"
    return f"static const {kind} tfra_calibrated_{name}[] = {{{values}}};"
