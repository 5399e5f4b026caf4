"""Output frames of a skin, taken apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

from .frame import Frame, header_and_words, in_units, refuse_cut, words_of
from .registers import CONSTANTS, DeviceError, names

_WINDOW = "window."
_RECORD: dict[str, int] = CONSTANTS["record"]
"""Places of the words before those of a window."""


@dataclass(frozen=True)
class Contact:
    """A contact: ``x`` and ``y`` of its region's centroid in m from the first taxel, the region's ``taxels``.

    ``window``: what the estimator made of the window about it; its header is that of the frame.  ``words``: those of
    the record before those of the window, as integers.
    """

    x: float
    y: float
    taxels: int
    marks: frozenset[str]
    window: Frame
    words: Mapping[str, int]


@dataclass(frozen=True)
class SkinFrame:
    """An output frame of a skin; ``dropped``: peaks beyond as many contacts as there may be."""

    sequence: int
    user: int
    faults: frozenset[str]
    dropped: int
    contacts: tuple[Contact, ...]


def read_contacts(facts: Mapping[str, Any], source: BinaryIO, taxel_forces: bool = True) -> bytes:
    """The bytes of the next output frame in a stream, its records up to the last one."""
    size = 4 * sum(field["count"] for field in _fields(facts, taxel_forces))
    last = 4 * _RECORD["last"]
    data = source.read(4 * CONSTANTS["header_beats"])
    while record := source.read(size):
        data += record
        if record[last : last + 4] != bytes(4):
            break
    return data


def parse_contacts(facts: Mapping[str, Any], data: bytes) -> SkinFrame:
    """Take an output frame of a skin apart: ``data`` are all its beats, lowest byte first.

    Raises ``DeviceError`` for a frame that a soft reset ended, and for another length or format.
    """
    refuse_cut(data)
    if len(data) % 4 or len(data) <= 4 * CONSTANTS["header_beats"]:
        raise DeviceError(f"{len(data)} bytes are no frame")
    header, beats = header_and_words(data, CONSTANTS["records_format"])
    for taxel_forces in (True, False):
        fields = _fields(facts, taxel_forces)
        size = sum(field["count"] for field in fields)
        records = [beats[start : start + size] for start in range(0, len(beats), size)]
        if len(beats) % size == 0 and _follow(records):
            break
    else:
        raise DeviceError(f"{len(data)} bytes are no header and whole records")
    contacts = [_contact(fields, header, record) for record in records if record[_RECORD["taxels"]]]
    faults = names("ERRORS", header["faults"])
    return SkinFrame(header["sequence"], header["user"], faults, records[-1][_RECORD["dropped"]], tuple(contacts))


def _fields(facts: Mapping[str, Any], taxel_forces: bool) -> list[dict[str, Any]]:
    """Fields of a record."""
    fields = facts["result"]["fields"]
    return [field for field in fields if taxel_forces or field["name"] != f"{_WINDOW}forces"]


def _follow(records: Sequence[Sequence[int]]) -> bool:
    """Whether they are those of one frame: they have its number, theirs, and one of them is the last."""
    frame = records[0][_RECORD["frame"]]
    found = [tuple(record[_RECORD[name]] for name in ("frame", "contact", "last")) for record in records]
    return found == [(frame, number, int(number == len(records) - 1)) for number in range(len(records))]


def _contact(fields: Sequence[Mapping[str, Any]], header: Mapping[str, int], record: Sequence[int]) -> Contact:
    words, lsb = words_of(fields, record), {field["name"]: field["lsb"] for field in fields}
    (row,), (column,) = words["row"], words["column"]
    marks = frozenset(name for name, flag in CONSTANTS["marks"].items() if words["marks"][0] & flag)
    inner = [{**field, "name": field["name"].removeprefix(_WINDOW)} for field in fields if _WINDOW in field["name"]]
    window = in_units(header, inner, {field["name"]: words[_WINDOW + field["name"]] for field in inner})
    own = {name: words[name][0] for name in _RECORD}
    return Contact(column * lsb["column"], row * lsb["row"], own["taxels"], marks, window, own)
