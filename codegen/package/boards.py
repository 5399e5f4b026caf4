"""Boards: the core behind a serial line, the way to a bitstream, and a program for the host."""

import json
from typing import Any

import numpy as np
from amaranth import ClockDomain, ClockSignal, DomainRenamer, Module, ResetSignal, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect

from tfra.codegen.package.contents import Contents
from tfra.codegen.verilog.emit import core_instance, plain_verilog, to_rtlil
from tfra.families.family import Board
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.uart.bridge import CODE_BYTES, WORD_BYTES, Bridge, coefficient_bytes
from tfra.hdl.uart.uart import Rx, Tx
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin

BAUD = 1_000_000
"""Bits a second of the line."""

TOP = "top"
PORTS = ("clock", "button", "rx", "tx", "alive", "dropped", "waits")

_START_BITS = 10
"""Of the counter that holds the reset after power-up, until block memories can be read."""

_CHECKED = 4
_SEED = 2
"""Simulated contacts that the host's program compares, and their seed."""


class BoardTop(wiring.Component):
    """The core of ``design``, an instance of its Verilog module, behind a serial line.

    Members: ``clock``; ``button``: resets while it is pressed; ``rx``, ``tx``: the line at ``BAUD``, on which a break
    resets, too; lamps: ``alive`` changes with each result frame, ``dropped`` shows that a frame was dropped since the
    reset, ``waits`` that the core waits for coefficients.
    """

    def __init__(self, design: Design, board: Board) -> None:
        self._design, self._board, self._divisor = design, board, board.clock_hz // BAUD
        inputs = {"clock": In(1), "button": In(1), "rx": In(1)}
        super().__init__({**inputs, "tx": Out(1), "alive": Out(1), "dropped": Out(1), "waits": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.domains.sync = ClockDomain(local=True)
        m.domains.line = ClockDomain(local=True, reset_less=True)
        m.submodules.receiver = rx = DomainRenamer("line")(Rx(self._divisor))
        m.submodules.transmitter = tx = Tx(self._divisor)
        m.submodules.bridge = bridge = Bridge(self._design)
        m.submodules.restart = restart = DomainRenamer("line")(_Restart())
        connect(m, rx.o, bridge.i)
        connect(m, bridge.o, tx.i)
        m.d.comb += [
            ClockSignal("sync").eq(self.clock),
            ClockSignal("line").eq(self.clock),
            restart.button.eq(self.button ^ self._board.inverted),
            restart.broken.eq(rx.broken),
            ResetSignal().eq(restart.reset),
            rx.line.eq(self.rx),
            self.tx.eq(tx.line),
            bridge.fault.eq(rx.fault),
        ]
        alive, dropped = Signal(name="alive_word"), Signal(name="dropped_word")
        with m.If(bridge.result.valid & bridge.result.ready & bridge.result.payload.last):
            m.d.sync += alive.eq(~alive)
        with m.If(bridge.dropped):
            m.d.sync += dropped.eq(1)
        for lamp, lit in ((self.alive, alive), (self.dropped, dropped), (self.waits, bridge.load.ready)):
            m.d.comb += lamp.eq(lit ^ self._board.inverted)
        m.submodules.core = core_instance(self._design, bridge, ResetSignal())
        return m


class _Restart(wiring.Component):
    """The reset, from a register: after power-up, and while ``button`` or ``broken`` is high."""

    def __init__(self) -> None:
        super().__init__({"button": In(1), "broken": In(1), "reset": Out(1, init=1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        count = Signal(_START_BITS)
        button = delayed(m, self.button, 2, "button", control=True)
        with m.If(~count.all()):
            m.d.sync += count.eq(count + 1)
        m.d.comb += self.reset.eq(register(m, ~count.all() | button | self.broken, "reset_word", control=True))
        return m


def boards(contents: Contents) -> dict[str, str]:
    """``boards/BOARD``: top module, constraints, a script; ``boards/talk.py`` talks to it.  A skin has none."""
    board = contents.part.target.family.board
    if board is None or isinstance(contents.array, Skin):  # the line carries frames of one length
        return {}
    folder = f"boards/{board.name}"
    size = contents.part.target.part.rpartition("-")[2]
    design, loaded = contents.design, contents.core.loaded
    codes = contact_codes(design, _CHECKED, _SEED)
    line = {  # what the host's program needs: sizes of words in bytes, and frames with the words that are due for them
        "code_bytes": CODE_BYTES,
        "word_bytes": WORD_BYTES,
        "coefficient_bytes": 0 if loaded is None else coefficient_bytes(design),
        "coefficient_bits": design.coefficient_word,
        "codes": codes.reshape(len(codes), -1).tolist(),
        "words": np.asarray(design.model(codes).words).tolist(),
    }
    return {
        **{f"{folder}/{file}": contents.fill(f"{board.name}_{file}", size=size) for file in board.files},
        f"{folder}/top.v": plain_verilog(to_rtlil(BoardTop(design, board), TOP), TOP, PORTS),
        "boards/talk.py": contents.fill("talk.py.txt", baud=BAUD),
        "boards/line.json": json.dumps(line) + "\n",
    }
