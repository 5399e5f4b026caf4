"""Payloads and ports of a skin's blocks."""

from amaranth import Shape, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Member, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.model.skin.finding import LARGEST_GAP, MOST, THRESHOLD_FRACTION, Finding
from tfra.model.skin.records import header_bits
from tfra.model.skin.skin import Skin
from tfra.model.skin.smoothing import GAIN

PAGES = 2
"""Frames in the memories: one is taken while the one before is searched."""

THRESHOLD = counter_shape(1 << THRESHOLD_FRACTION)
"""The threshold as the comparison has it."""
GAP = counter_shape(LARGEST_GAP)


def settings(choices: Finding) -> wiring.Signature:
    """How contacts are told apart: ``choices`` unless they are driven; other values than it allows are not."""
    return wiring.Signature({
        "most": Out(counter_shape(MOST), init=choices.most),
        "threshold": Out(THRESHOLD, init=choices.word),
        "gap": Out(GAP, init=choices.gap),
    })


def setting_ports(skin: Skin) -> dict[str, Member]:
    """The settings by the names of a core's ports."""
    return {f"contacts_{name}": member for name, member in settings(skin.choices).members.items()}


def height(skin: Skin) -> Shape:
    """Smoothed compression at a taxel."""
    return unsigned((GAIN << (skin.adc.bits - 1)).bit_length())


def row(skin: Skin) -> Shape:
    """A row of the array."""
    return counter_shape(skin.sensor.rows - 1)


def column(skin: Skin) -> Shape:
    """A column of the array."""
    return counter_shape(skin.sensor.columns - 1)


def place(skin: Skin) -> data.StructLayout:
    """A taxel."""
    return data.StructLayout({"column": column(skin), "row": row(skin)})


def peak(skin: Skin) -> data.StructLayout:
    """A peak of the smoothed frame."""
    return data.StructLayout({"height": height(skin), "place": place(skin)})


def most_peaks(skin: Skin) -> int:
    """Most peaks of a frame: no two are neighbours."""
    return -(-skin.sensor.rows // 2) * -(-skin.sensor.columns // 2)


def _span(skin: Skin, index: Shape, size: int) -> data.StructLayout:
    """See :class:`tfra.model.skin.regions.Span`; ``size`` indices."""
    total = unsigned((skin.sensor.taxels * (size - 1)).bit_length())
    return data.StructLayout({"first": index, "last": index, "total": total})


def region(skin: Skin) -> data.StructLayout:
    """What is known of a contact's region; one without taxels stands for a frame without contact."""
    rows, columns = skin.sensor.rows, skin.sensor.columns
    return data.StructLayout({
        "taxels": unsigned(header_bits(skin)["taxels"]),
        "rows": _span(skin, row(skin), rows),
        "columns": _span(skin, column(skin), columns),
        "touching": 1,
    })


def contact(skin: Skin) -> data.StructLayout:
    """A contact: words of its header, and the first row and column of its window."""
    bits = header_bits(skin)
    header = {name: unsigned(bits[name]) for name in ("row", "column", "taxels", "marks")}
    corner = {"top": signed(row(skin).width + 1), "left": signed(column(skin).width + 1)}
    return data.StructLayout(header | corner)


def ending(skin: Skin) -> data.StructLayout:
    """What is known of a record when its frame is searched again: it is the ``last``, and peaks are ``dropped``."""
    bits = header_bits(skin)
    return data.StructLayout({name: unsigned(bits[name]) for name in ("last", "dropped")})


def bitmap(skin: Skin) -> wiring.Signature:
    """A way to a memory with a word of a bit a taxel for each row."""
    word = unsigned(skin.sensor.columns)
    return wiring.Signature({
        "row": Out(row(skin)),  # to be read ...
        "word": In(word),  # ... a cycle later
        "write": Out(1),
        "target": Out(row(skin)),  # row that is written ...
        "data": Out(word),  # ... with this word
    })
