"""A skin in C: the files of its window's core, what finds contacts and calls it, and a test of that."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from tfra.codegen.blocks.result import gathered
from tfra.codegen.blocks.tables import numbers
from tfra.codegen.blocks.types import types
from tfra.codegen.c.files import core, files, filled, shared
from tfra.codegen.c.memory import c_type, ram_bytes, size_of, stack_bytes
from tfra.codegen.sidecar.build import HEADER, sidecar
from tfra.model.arrays import Ints
from tfra.model.skin.finding import LARGEST_GAP, MARK_SHIFT, MOST, THRESHOLD_FRACTION, Found
from tfra.model.skin.records import header_bits
from tfra.model.skin.scenes import recorded
from tfra.model.skin.skin import Skin
from tfra.model.skin.smoothing import GAIN
from tfra.model.skin.windows import PLACE_FRACTION
from tfra.recordings.skin_facts import MARKS

_FRAMES_OF_CALLS = 256
"""Bytes of a stack for the functions that find contacts."""

_SINGLE = ("settings", "frame", "dropped")
"""Members of the state that are no arrays."""

_CORNERS = {
    "top": "first row of its window, may be beyond the array",
    "left": "first column of its window, may be beyond the array",
}
_MEANINGS = {name: text for name, text in HEADER.items() if name not in ("last", "dropped")} | _CORNERS


def skin_files(skin: Skin) -> dict[str, str]:
    """Text of every file of ``skin`` by its name: those of its window's core among them; raises as :func:`files`."""
    texts = files(skin.window)
    values = _values(skin, sidecar(skin.window))
    for name, added in (("CMakeLists.txt", "skin.cmake"), ("README.md", "skin.md")):
        texts[name] += filled(added, values)
    return texts | _sources(skin, values) | {f"{skin.window.name}_skin_test.c": _test(skin, values)}


def skin_core(skin: Skin) -> dict[str, str]:
    """Headers, sources and tables."""
    facts = sidecar(skin.window)
    return core(skin.window, facts) | _sources(skin, _values(skin, facts))


def skin_ram_bytes(skin: Skin) -> int:
    """Bytes of the state."""
    longest = size_of(types(skin.window)["vector_t"])
    used = ram_bytes(skin.window) + sum(size * count for _, _, size, count in _members(skin))
    return -(-used // longest) * longest


def skin_stack_bytes(skin: Skin) -> int:
    """A bound for the stack."""
    return stack_bytes(skin.window) + _FRAMES_OF_CALLS


def _sources(skin: Skin, values: dict[str, object]) -> dict[str, str]:
    name = skin.window.name
    return {
        f"{name}_skin.h": filled("skin.h", values, **_header(skin)),
        f"{name}_skin.c": filled("skin.c", values, **_source(skin)),
    }


def _values(skin: Skin, facts: Mapping[str, Any]) -> dict[str, object]:
    """What the templates share, with the sidecar's ``facts`` of the window."""
    return shared(skin.window, facts) | {
        "rows": skin.sensor.rows,
        "columns": skin.sensor.columns,
        "taxels": skin.sensor.taxels,
        "most": skin.choices.most,
        "ram": skin_ram_bytes(skin),
        "stack": skin_stack_bytes(skin),
    }


def _header(skin: Skin) -> dict[str, object]:
    name = skin.window.name.upper()
    marks = (f"    {name}_{mark.name} = {mark >> MARK_SHIFT}, // {text}" for mark, text in MARKS.items())
    state = (
        f"    {kind} {member};" if member in _SINGLE else f"    {kind} {member}[{words}];"
        for kind, member, _, words in _members(skin)
    )
    return {
        "largest_most": MOST,
        "largest_gap": LARGEST_GAP,
        "threshold_one": 1 << THRESHOLD_FRACTION,
        "place_lsb": 2.0**-PLACE_FRACTION,
        "fields": "\n".join(f"    {kind} {field}; // {_MEANINGS[field]}" for field, kind in _fields(skin).items()),
        "marks": "\n".join(["enum {", *marks, "};"]),
        "state": "\n".join([f"    {skin.window.name}_state window;", *state]),
    }


def _fields(skin: Skin) -> dict[str, str]:
    """Types of a contact's fields."""
    bits = header_bits(skin)
    corner = max(skin.sensor.rows, skin.sensor.columns).bit_length() + 1
    unsigned = {field: c_type(bits[field], signed=False) for field in bits if field in _MEANINGS}
    return unsigned | {"top": c_type(corner), "left": c_type(corner)}


def _members(skin: Skin) -> list[tuple[str, str, int, int]]:
    """Type, name, bytes and words of every member of the state after the window's, the longest types first."""
    rows, columns = skin.sensor.rows, skin.sensor.columns
    code = size_of(skin.adc.bits)
    index, count = _index_bits(skin), header_bits(skin)["dropped"]
    index_type, index_size = c_type(index, signed=False), size_of(index, signed=False)
    found = [
        ("int32_t", "smooth", 4, (rows + 2) * (columns + 2)),
        ("int32_t", "line", 4, columns + 2),
        (index_type, "region", index_size, skin.sensor.taxels),
        (index_type, "candidates", index_size, -(-rows // 2) * -(-columns // 2)),  # no two peaks are neighbours
        (f"{skin.window.name}_code", "cut", code, skin.window.sensor.taxels),
        (f"{skin.window.name}_finding", "settings", 2, 3),
        ("uint16_t", "frame", 2, 1),
        (c_type(count, signed=False), "dropped", size_of(count, signed=False), 1),
        ("uint8_t", "use", 1, (rows + 2) * (columns + 2)),
        ("uint8_t", "peak", 1, columns),
    ]
    return sorted(found, key=lambda member: -member[2])


def _index_bits(skin: Skin) -> int:
    """Bits of a taxel's index in the array with a border."""
    return ((skin.sensor.rows + 2) * (skin.sensor.columns + 2)).bit_length()


def _source(skin: Skin) -> dict[str, object]:
    constants = {
        "ROWS": skin.sensor.rows,
        "COLUMNS": skin.sensor.columns,
        "TAXELS": skin.sensor.taxels,
        "CODE_TOP": (1 << (skin.adc.bits - 1)) - 1,
        "LEAST": f"{max(1, GAIN * skin.adc.threshold)} // of a peak",
        "THRESHOLD_FRACTION": THRESHOLD_FRACTION,
        "PLACE_FRACTION": PLACE_FRACTION,
        "LARGEST_GAP": LARGEST_GAP,
        "MOST": skin.choices.most,
        "THRESHOLD": skin.choices.word,
        "GAP": skin.choices.gap,
    }
    stored = ((field, "found" if field == "marks" else field) for field in _fields(skin))
    return {
        "constants": "\n".join(f"#define {key} {value}" for key, value in constants.items()),
        "index": c_type(_index_bits(skin), signed=False),
        "peaks_type": c_type(header_bits(skin)["dropped"], signed=False),
        "stored": "\n".join(
            f"    contact->{field} = ({_fields(skin)[field]}){value};"
            for field, value in stored
            if field not in ("frame", "contact")
        ),
    }


def _test(skin: Skin, values: dict[str, object]) -> str:
    codes = recorded(skin)
    found, cut = skin.find(codes)
    header = np.stack(list(_header_of(found).values()), axis=1)
    expected = np.concatenate([header, skin.window.model(cut).words], axis=1)
    fields = [*enumerate(_fields(skin)), *((header.shape[1] + f.start, f"window.{f.name}") for f in skin.window.layout)]
    counts = zip(found.found, found.dropped, strict=True)
    return filled(
        "skin_test.c",
        values,
        frames=len(codes),
        contacts=len(expected),
        words=expected.shape[1],
        codes=",\n".join(f"    {{\n{numbers(frame.ravel())}}}" for frame in codes),
        counts=",\n".join(f"    {{{contacts}, {dropped}}}" for contacts, dropped in counts),
        expected=",\n".join(f"    {{\n{numbers(contact)}}}" for contact in expected),
        names=",\n".join(f'    {{{first}, "{name}"}}' for first, name in fields),
        header="\n".join(f"    words[place++] = contact->{field};" for field in _fields(skin)),
        gather=gathered(skin.window),
    )


def _header_of(found: Found) -> dict[str, Ints]:
    """What was ``found``, as a contact in C has it."""
    return {field: getattr(found, field) for field in _MEANINGS} | {"marks": found.marks >> MARK_SHIFT}
