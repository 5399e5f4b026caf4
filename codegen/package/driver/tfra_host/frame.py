"""Output frames, taken apart."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .registers import CONSTANTS, DeviceError, names, part, signed


@dataclass(frozen=True)
class Frame:
    """An output frame: forces in N, ``phi_deg`` in degrees; None for what it does not have.

    ``forces``: f_x of all taxels, row by row, then f_y, f_z.  ``words``: all words of the result as integers, by field.
    """

    sequence: int
    user: int
    faults: frozenset[str]
    status: frozenset[str]
    resultant: tuple[float, float, float]
    phi_deg: float
    mu: float
    mu_x: float
    mu_y: float
    uncertainty: float | None
    forces: tuple[tuple[float, ...], ...] | None
    words: Mapping[str, tuple[int, ...]]


def frame_bytes(facts: Mapping[str, Any], taxel_forces: bool = True) -> int:
    """Bytes of an output frame, with ``CONTROL.taxel_forces`` as stated."""
    counts = (field["count"] for field in facts["result"]["fields"] if taxel_forces or field["name"] != "forces")
    beats: int = CONSTANTS["header_beats"] + sum(counts)
    return 4 * beats


def parse_frame(facts: Mapping[str, Any], data: bytes) -> Frame:
    """Take an output frame apart: ``data`` are all its beats, lowest byte first.

    Raises ``DeviceError`` for a frame that a soft reset ended, and for another length or format.
    """
    whole, short = frame_bytes(facts), frame_bytes(facts, taxel_forces=False)
    refuse_cut(data)
    if len(data) not in (whole, short):
        raise DeviceError(f"a frame has {whole} bytes, or {short} without forces at the taxels, not {len(data)}")
    header, beats = header_and_words(data, CONSTANTS["frame_format"])
    fields = [field for field in facts["result"]["fields"] if field["name"] != "forces" or len(data) == whole]
    return in_units(header, fields, words_of(fields, beats))


def refuse_cut(data: bytes) -> None:
    """Raise ``DeviceError`` for a frame that a soft reset ended."""
    if data[-4:] == CONSTANTS["frame_cut"].to_bytes(4, "little"):
        raise DeviceError("a soft reset ended the frame")


def header_and_words(data: bytes, form: int) -> tuple[dict[str, int], tuple[int, ...]]:
    """Fields of the header of an output frame, and the beats after it; raises ``DeviceError`` for another format."""
    beats = struct.unpack(f"<{len(data) // 4}I", data)
    header = {name: part(beats[beat], low, bits) for name, (beat, low, bits) in CONSTANTS["header"].items()}
    if header["format"] != form:
        raise DeviceError(f"the frame has the format {header['format']}")
    return header, beats[CONSTANTS["header_beats"] :]


def words_of(fields: Sequence[Mapping[str, Any]], beats: Sequence[int]) -> dict[str, tuple[int, ...]]:
    """The words of ``fields``, one after the other in ``beats``; raises ``DeviceError`` for one that is too long."""
    words, place = {}, 0
    for field in fields:
        words[field["name"]] = _extended(field, beats[place : place + field["count"]])
        place += field["count"]
    return words


def in_units(
    header: Mapping[str, int], fields: Sequence[Mapping[str, Any]], words: Mapping[str, tuple[int, ...]]
) -> Frame:
    """A result from its ``words`` by ``fields``."""
    lsb = {field["name"]: field["lsb"] for field in fields}
    values = {name: [word * lsb[name] for word in found] for name, found in words.items()}
    newton = 0.5 ** words["exponent"][0]
    x, y, z = (newton * value for value in values["resultant"])
    taxels, forces = len(words.get("forces", ())) // 3, [newton * value for value in values.get("forces", ())]
    flags = CONSTANTS["status"].items()
    return Frame(
        sequence=header["sequence"],
        user=header["user"],
        faults=names("ERRORS", header["faults"]),
        status=frozenset(name for name, flag in flags if words["status"][0] & flag),
        resultant=(x, y, z),
        phi_deg=values["phi"][0],
        mu=values["mu"][0],
        mu_x=values["mu_x"][0],
        mu_y=values["mu_y"][0],
        uncertainty=newton * values["uncertainty"][0] if "uncertainty" in values else None,
        forces=tuple(tuple(forces[axis * taxels : (axis + 1) * taxels]) for axis in range(3)) if forces else None,
        words=words,
    )


def _extended(field: Mapping[str, Any], beats: Sequence[int]) -> tuple[int, ...]:
    """Words of a field; raises ``DeviceError`` for one whose upper bits do not extend it."""
    for beat in beats:
        word = signed(beat, field["bits"]) if field["signed"] else part(beat, 0, field["bits"])
        if word & 0xFFFFFFFF != beat:
            raise DeviceError(f"a word of {field['name']} has more than {field['bits']} bits")
    return tuple(signed(beat, 32) for beat in beats) if field["signed"] else tuple(beats)
