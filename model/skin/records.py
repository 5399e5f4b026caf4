"""The words of a skin's core: a record for each contact, its header before the words of its window's core.

A frame without contact has one record, whose window is zero and whose region has no taxel.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import COUNTER_BITS, Field
from tfra.model.fixed.words import decode
from tfra.model.rounding import Overflow
from tfra.model.skin.finding import MARK_SHIFT, MOST, Found, Mark
from tfra.model.skin.result import SkinResult, skin_result
from tfra.model.skin.skin import Skin
from tfra.model.skin.windows import PLACE_FRACTION, corners


def header_bits(skin: Skin) -> dict[str, int]:
    """Bits of the words in front of those of a window, all unsigned, by their names in order.

    ``frame``; ``contact``, its number in the frame; ``last``: the frame has no further one; ``dropped``: peaks that are
    left then, 0 before; ``row`` and ``column`` of the centroid; ``taxels`` of the region; ``marks``.
    """
    rows, columns = skin.sensor.rows, skin.sensor.columns
    return {
        "frame": COUNTER_BITS,
        "contact": (MOST - 1).bit_length(),
        "last": 1,
        "dropped": (-(-rows // 2) * -(-columns // 2)).bit_length(),
        "row": (rows - 1).bit_length() + PLACE_FRACTION,
        "column": (columns - 1).bit_length() + PLACE_FRACTION,
        "taxels": skin.sensor.taxels.bit_length(),
        "marks": len(Mark),
    }


def record_layout(skin: Skin) -> tuple[Field, ...]:
    """Fields of a record, those of the window's words under ``window.NAME``."""
    bits = header_bits(skin)
    scales = {"row": skin.sensor.pitch_y, "column": skin.sensor.pitch_x}
    header = [
        Field(
            name,
            start,
            1,
            bits[name],
            False,
            PLACE_FRACTION if name in scales else 0,
            scales.get(name, 1.0),
            "m" if name in scales else "1",
            Overflow.WRAP if name == "frame" else Overflow.NEVER,
        )
        for start, name in enumerate(bits)
    ]
    words = (replace(field, name=f"window.{field.name}", start=field.start + len(bits)) for field in skin.window.layout)
    return (*header, *words)


def result_layout(array: Design | Skin) -> tuple[Field, ...]:
    """Fields of a result frame or of a record."""
    return record_layout(array) if isinstance(array, Skin) else array.layout


def ends(skin: Skin, given: Ints) -> Bools:
    """Which of the records ``(k, words)`` are the last one of their frame."""
    return np.asarray(given[:, list(header_bits(skin)).index("last")] == 1)


def record_bits(skin: Skin) -> int:
    """Bits of a word of a record, signed."""
    return max(skin.window.word_bits, *(bits + 1 for bits in header_bits(skin).values()))


def record_words(skin: Skin) -> int:
    """Words of a record."""
    return len(header_bits(skin)) + skin.window.frame_words


def result_shape(array: Design | Skin) -> tuple[int, int]:
    """Words of a result frame or of a record, and bits of a word, signed."""
    if isinstance(array, Skin):
        return record_words(array), record_bits(array)
    return array.frame_words, array.word_bits


def records(skin: Skin, codes: Ints, words: Callable[[Ints], Ints]) -> Ints:
    """Records ``(k, header + frame_words)`` of converter ``codes (n, rows, columns)``.

    ``words`` are those of windows by the window's design; its frames are the windows, counted from zero.
    """
    found, cut = skin.find(codes)
    empty = np.flatnonzero(found.found == 0)
    ordered = np.argsort(np.concatenate([found.frame, empty]), kind="stable")

    def every(each: Ints, otherwise: Ints | int = 0) -> Ints:
        """A value of each record from those of the contacts, and those ``otherwise``."""
        rest = np.broadcast_to(np.asarray(otherwise, dtype=np.int64), (len(empty), *each.shape[1:]))
        return np.concatenate([each, rest])[ordered]

    frame, contact = every(found.frame, empty), every(found.contact)
    last = contact == np.maximum(found.found[frame] - 1, 0)
    header = {
        "frame": frame % (1 << COUNTER_BITS),
        "contact": contact,
        "last": last.astype(np.int64),
        "dropped": np.where(last, found.dropped[frame], 0),
        "row": every(found.row),
        "column": every(found.column),
        "taxels": every(found.taxels),
        "marks": every(found.marks >> MARK_SHIFT),
    }
    return np.concatenate([np.stack([header[name] for name in header_bits(skin)], axis=1), words(every(cut))], axis=1)


def results(array: Design | Skin, codes: Ints) -> list[Ints]:
    """Words ``(1, words)`` of each frame of ``codes (n, rows, columns)``, of a skin those of its records."""
    if not isinstance(array, Skin):
        return list(array.model(codes).words[:, None])
    given = records(array, codes, array.window.model.words)
    return np.split(given, np.flatnonzero(ends(array, given))[:-1] + 1)


def decode_records(skin: Skin, given: Ints) -> SkinResult:
    """The contacts of whole frames from their records ``(k, words)``; frames are numbered by their order."""
    count = len(header_bits(skin))
    header = dict(zip(header_bits(skin), given[:, :count].T, strict=True))
    last = ends(skin, given)
    frame: Ints = np.cumsum(last) - last
    there = header["taxels"] > 0
    at = {name: header[name][there] for name in header}
    rows, columns = skin.shape
    found = Found(
        frame=frame[there],
        row=at["row"],
        column=at["column"],
        taxels=at["taxels"],
        top=corners(at["row"], rows),
        left=corners(at["column"], columns),
        marks=at["marks"] << MARK_SHIFT,
        dropped=header["dropped"][last],
    )
    return skin_result(skin, found, decode(skin.window, given[there, count:]))
