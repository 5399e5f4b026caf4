"""The serial core: one instruction a cycle, for FPGAs too small for :mod:`tfra.hdl.parallel.tfra.core`."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl import ports
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.streams import Buffer, Spare
from tfra.hdl.serial.datapath import Datapath
from tfra.hdl.serial.isa import Dest, Op, Src
from tfra.hdl.serial.lanes import Lanes
from tfra.hdl.serial.product import Product
from tfra.hdl.serial.program.frame import Program
from tfra.hdl.serial.sequencer import Sequencer
from tfra.hdl.serial.sizes import sizes
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import Ints


class SerialCore(wiring.Component):
    """Triaxial contact forces of a stream of tactile frames, one instruction of a fixed program a cycle.

    Members:
        load: coefficients ``store (depth, lanes)`` after a reset, row by row.
        taxel: converter codes, row-major, ``m`` transfers a frame.
        result: words of ``design.layout``, ``last`` on a frame's final word.

    Both streams of frames may stall at any time; then the program waits.  Latency and interval are stated by
    :class:`tfra.hdl.serial.serial.Serial`.
    """

    def __init__(self, design: Design, program: Program, store: Ints) -> None:
        self.design, self.program, self._store = design, program, store
        super().__init__(
            {
                "load": In(stream.Signature(signed(design.formats.coefficient))),
                "taxel": In(stream.Signature(ports.taxel(design))),
                "result": Out(stream.Signature(ports.result(design))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m, size, code = Module(), sizes(self.design), self.program
        m.submodules.taxels = taxels = Buffer(self.taxel.payload.shape())
        m.submodules.results = results = Spare(self.result.payload.shape())
        m.submodules.sequencer = sequencer = Sequencer(code.instructions)
        m.submodules.memory = memory = Memory(shape=signed(size.word), depth=len(code.memory), init=code.memory)
        m.submodules.lanes = lanes = Lanes(size, self.design.quads, code.operands, len(self._store), self.design.target)
        m.submodules.product = product = Product(size.multiplicand, size.multiplier, size.word)
        m.submodules.datapath = path = Datapath(size, self.taxel.payload.shape())
        connect(m, flipped(self.taxel), taxels.i)
        connect(m, results.o, flipped(self.result))
        loading, o, e, read, write = self._load(m, lanes), path.o, path.e, memory.read_port(), memory.write_port()
        m.d.comb += [
            path.advance.eq(~loading & ~(path.takes & ~taxels.o.valid) & ~(path.gives & ~results.i.ready)),
            sequencer.advance.eq(path.advance),
            path.decoded.eq(Cat(sequencer.instruction, sequencer.address, sequencer.valid)),
            sequencer.set_pointer.eq(path.delivers & (e.instruction.dest == Dest.P)),
            sequencer.number.eq(e.instruction.pointer),
            sequencer.value.eq(path.total),
            read.addr.eq(sequencer.address),
            read.en.eq(path.advance),
            path.memory.eq(read.data),
            write.data.eq(path.last),
            product.a.eq(path.source),
            product.b.eq(path.y),
            product.start.eq(e.instruction.op == Op.MUL),
            product.enable.eq(path.advance),
            path.product.eq(product.o),
            lanes.write.eq(write.en & (write.addr[len(lanes.write_address) :] == 0)),
            lanes.write_address.eq(write.addr),
            lanes.write_data.eq(path.last),
            lanes.start.eq(path.acts & (e.instruction.op == Op.MAC)),
            lanes.address.eq(e.address),
            lanes.next.eq(path.advance & o.valid & (o.instruction.source == Src.SUM)),
            lanes.set_pointer.eq(path.delivers & (e.instruction.dest == Dest.SP)),
            lanes.pointer.eq(path.total),
            path.sum.eq(lanes.sum),
            taxels.o.ready.eq(path.takes & path.advance),
            path.taxel.eq(taxels.o.payload),
            results.i.valid.eq(path.gives & path.advance),
            results.i.payload.data.eq(path.last),
            results.i.payload.last.eq(path.ends),
        ]
        m.d.sync += write.en.eq(path.delivers & (e.instruction.dest == Dest.M))
        with m.If(path.advance):
            m.d.sync += write.addr.eq(e.address)
        return m

    def _load(self, m: Module, lanes: Lanes) -> Signal:
        """Collect coefficients to words of the store; high until the last one is there."""
        loading = Signal(init=1)
        depth, ways, bits = len(self._store), sizes(self.design).lanes, self.design.formats.coefficient
        lane, word = Signal(counter_shape(ways - 1)), Signal(bits * (ways - 1))
        left = Signal(counter_shape(depth - 1), init=depth - 1)
        m.d.comb += [
            self.load.ready.eq(loading),
            lanes.load.eq(loading & self.load.valid & (lane == ways - 1)),
            lanes.word.eq(Cat(word, self.load.payload)),
        ]
        with m.If(loading & self.load.valid):
            m.d.sync += [lane.eq(Mux(lane == ways - 1, 0, lane + 1)), word.eq(Cat(word, self.load.payload)[bits:])]
            with m.If(lane == ways - 1):
                m.d.sync += [left.eq(left - 1), loading.eq(left != 0)]
        return loading
