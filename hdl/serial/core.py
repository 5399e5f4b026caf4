"""The serial core: one instruction a cycle, for FPGAs too small for :mod:`tfra.hdl.parallel.tfra.core`."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.streams import Buffer, SkidBuffer
from tfra.hdl.serial.datapath import Datapath
from tfra.hdl.serial.isa import Dest, Op, Src
from tfra.hdl.serial.lanes import Lanes
from tfra.hdl.serial.product import Product
from tfra.hdl.serial.program.program import Program
from tfra.hdl.serial.sequencer import Sequencer
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design


class SerialCore(wiring.Component):
    """Triaxial contact forces of a stream of tactile frames, one instruction of a fixed program a cycle.

    Both streams of frames may stall at any time; then the program waits.  Latency and interval are stated by
    :class:`tfra.hdl.serial.serial.Serial`.

    ``datapath`` is an attribute so that a simulation can watch the instructions that are executed.
    """

    def __init__(self, design: Design, program: Program, store: Ints) -> None:
        self.design, self.program, self._store = design, program, store
        super().__init__({
            # coefficients ``store (depth, lanes)`` after a reset, row by row
            "load": In(stream.Signature(signed(design.formats.coefficient))),
            # converter codes, row-major, ``m`` transfers a frame
            "taxel": In(stream.Signature(ports.taxel(design))),
            # words of ``design.layout``, ``last`` on a frame's final word
            "result": Out(stream.Signature(ports.result(design))),
        })
        self.datapath = Datapath(program.sizes, self.taxel.payload.shape())

    def elaborate(self, platform: Any) -> Module:
        m, code, size, depth = Module(), self.program, self.program.sizes, len(self._store)
        m.submodules.datapath = self.datapath
        m.submodules.sequencer = sequencer = Sequencer(code.instructions)
        m.submodules.lanes = lanes = Lanes(size, code.lengths, code.operands, depth, self.design.target)
        m.submodules.product = product = Product(size.multiplicand, size.multiplier, size.word)
        loading = self._load(m, lanes)
        self._wire_streams(m, loading)
        self._wire_sequencer(m, sequencer)
        self._wire_memory(m, sequencer, lanes)
        self._wire_products(m, product, lanes)
        return m

    def _load(self, m: Module, lanes: Lanes) -> Signal:
        """Collect coefficients into words of the store; high until the last one has arrived."""
        depth, count, bits = len(self._store), self.program.sizes.lanes, self.design.formats.coefficient
        loading = Signal(init=1)
        lane = Signal(counter_shape(count - 1))
        word = Signal(bits * (count - 1))  # the coefficients of the lanes before
        words_left = Signal(counter_shape(depth - 1), init=depth - 1)
        m.d.comb += [
            self.load.ready.eq(loading),
            lanes.load.eq(loading & self.load.valid & (lane == count - 1)),
            lanes.word.eq(Cat(word, self.load.payload)),
        ]
        with m.If(loading & self.load.valid):
            m.d.sync += lane.eq(Mux(lane == count - 1, 0, lane + 1))
            m.d.sync += word.eq(Cat(word, self.load.payload)[bits:])
            with m.If(lane == count - 1):
                m.d.sync += words_left.eq(words_left - 1)
                m.d.sync += loading.eq(words_left != 0)
        return loading

    def _wire_streams(self, m: Module, loading: Signal) -> None:
        """Taxels and results; the program waits for both, and until the coefficients are loaded."""
        path = self.datapath
        m.submodules.taxels = taxels = Buffer(self.taxel.payload.shape())
        m.submodules.results = results = SkidBuffer(self.result.payload.shape())
        connect(m, flipped(self.taxel), taxels.i)
        connect(m, results.o, flipped(self.result))
        m.d.comb += [
            path.advance.eq(~loading & ~(path.takes & ~taxels.o.valid) & ~(path.gives & ~results.i.ready)),
            taxels.o.ready.eq(path.takes & path.advance),
            path.taxel.eq(taxels.o.payload),
            results.i.valid.eq(path.gives & path.advance),
            results.i.payload.data.eq(path.last),
            results.i.payload.last.eq(path.ends),
        ]

    def _wire_sequencer(self, m: Module, sequencer: Sequencer) -> None:
        path, i = self.datapath, self.datapath.executing.instruction
        m.d.comb += [
            sequencer.advance.eq(path.advance),
            path.decoded.instruction.eq(sequencer.instruction),
            path.decoded.address.eq(sequencer.address),
            path.decoded.valid.eq(sequencer.valid),
            sequencer.set_pointer.eq(path.delivers & (i.dest == Dest.P)),
            sequencer.pointer_number.eq(i.pointer),
            sequencer.pointer_value.eq(path.total),
        ]

    def _wire_memory(self, m: Module, sequencer: Sequencer, lanes: Lanes) -> None:
        """The data memory, and the lanes' copy of its lowest words; a result is written when it is in ``last``."""
        path, code = self.datapath, self.program
        shape = signed(code.sizes.word)
        m.submodules.memory = memory = Memory(shape=shape, depth=len(code.memory), init=code.memory)
        read, write = memory.read_port(), memory.write_port()
        m.d.comb += [
            read.addr.eq(sequencer.address),
            read.en.eq(path.advance),
            path.memory_word.eq(read.data),
            write.data.eq(path.last),
            lanes.write.eq(write.en & (write.addr[len(lanes.write_address) :] == 0)),
            lanes.write_address.eq(write.addr),
            lanes.write_data.eq(path.last),
        ]
        m.d.sync += write.en.eq(path.delivers & (path.executing.instruction.dest == Dest.M))
        with m.If(path.advance):
            m.d.sync += write.addr.eq(path.executing.address)

    def _wire_products(self, m: Module, product: Product, lanes: Lanes) -> None:
        path, i = self.datapath, self.datapath.executing.instruction
        m.d.comb += [
            product.a.eq(path.source),
            product.b.eq(path.y),
            product.start.eq(i.op == Op.MUL),
            product.enable.eq(path.advance),
            path.last_product.eq(product.o),
            lanes.start.eq(path.acts & (i.op == Op.MAC)),
            lanes.address.eq(path.executing.address),
            lanes.next.eq(path.advance & path.fetching.valid & (path.fetching.instruction.source == Src.SUM)),
            lanes.set_pointer.eq(path.delivers & (i.dest == Dest.SP)),
            lanes.pointer.eq(path.total),
            path.sum.eq(lanes.sum),
        ]
        if len(self.program.lengths) > 1:
            m.d.comb += lanes.length.eq(i.left)
