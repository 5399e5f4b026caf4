"""Cells of the Lattice iCE40 UltraPlus: its large memories."""

from amaranth import ClockSignal, Const, Instance, Module, Signal, Value

_WIDTH, _DEPTH = 16, 1 << 14
"""Bits and words of an SB_SPRAM256KA."""


def store(m: Module, bits: int, address: Value, write: Value, data: Value) -> Value:
    """SB_SPRAM256KA side by side: the word of ``bits`` at the ``address`` of the cycle before."""
    count = -(-bits // _WIDTH)
    padded = Signal(count * _WIDTH)
    found = Signal(count * _WIDTH)
    place = Signal(range(_DEPTH))
    m.d.comb += padded.eq(data)
    m.d.comb += place.eq(address)
    for number in range(count):
        part = slice(number * _WIDTH, (number + 1) * _WIDTH)
        m.submodules[f"block{number}"] = Instance(
            "SB_SPRAM256KA",
            i_ADDRESS=place,
            i_DATAIN=padded[part],
            i_MASKWREN=Const(0b1111, 4),
            i_WREN=write,
            i_CHIPSELECT=Const(1),
            i_CLOCK=ClockSignal(),
            i_STANDBY=Const(0),
            i_SLEEP=Const(0),
            i_POWEROFF=Const(1),
            o_DATAOUT=found[part],
        )
    return found
