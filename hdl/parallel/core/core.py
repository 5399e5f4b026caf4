"""The frame of a parallel core: its ports, its blocks, and the facts of a frame on their way between them."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from amaranth import Const, Module, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.lib.streams import Buffer, Fork, PerFrameFifo
from tfra.hdl.parallel.probes import add_probe


@dataclass(frozen=True)
class FactRoute:
    """``user`` reads ``fields`` of a fact at its port ``sink``; without fields it reads all."""

    user: str
    sink: Any
    fields: tuple[str, ...] = ()


@dataclass(frozen=True)
class Fact:
    """A fact of a frame that one block computes and others use: one transfer a frame from ``source`` to every sink."""

    name: str
    source: Any
    routes: tuple[FactRoute, ...]
    registered: bool = False
    """TIMING: a register between the source and its users, which are far from it."""


class Core(ABC, wiring.Component):
    """Blocks that stream to each other; frames follow each other without a gap or a reset, and any port may stall.

    A subclass states its blocks, its probes and the depth of its facts, and wires its blocks.
    """

    fact_depth: ClassVar[int]
    """Most frames whose facts the core stores."""

    def __init__(self, design: Any) -> None:
        self.design = design
        # Coefficients after a reset, lane by lane as matvec.images.lane_images has them; taxels wait for the last one.
        load = {"load": In(stream.Signature(signed(design.coefficient_word)))} if design.images == "load" else {}
        super().__init__({
            **load,
            "taxel": In(stream.Signature(ports.taxel(design))),  # converter codes, row-major
            "result": Out(stream.Signature(ports.result(design))),  # words of ``design.layout``
        })

    @staticmethod
    @abstractmethod
    def blocks(design: Any) -> Any:
        """The blocks of ``design``, by name in dataflow order."""

    @staticmethod
    @abstractmethod
    def probes(design: Any) -> Sequence[Probe]:
        """Streams between blocks that a simulation may watch, in the order in which data reach them."""

    @abstractmethod
    def wire(self, m: Module, blocks: Any) -> None:
        """Connect the blocks with each other and with ``result``."""

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        blocks = self.blocks(self.design)
        for name, block in blocks:
            m.submodules[name] = block
        self.wire(m, blocks)
        by_name = dict(blocks)
        for probe in self.probes(self.design):
            add_probe(m, probe, by_name[probe.stage])
        return m

    def wire_taxels(self, m: Module, blocks: Any, sink: Any) -> None:
        """Taxels to ``sink``, and coefficients to the lanes before them."""
        go: Value = Const(1)
        if self.design.images == "load":
            connect(m, flipped(self.load), blocks.matvec.load)
            go = ~blocks.matvec.loading
        m.d.comb += [
            sink.payload.eq(self.taxel.payload),
            sink.valid.eq(self.taxel.valid & go),
            self.taxel.ready.eq(sink.ready & go),
        ]

    def wire_fact(self, m: Module, fact: Fact) -> None:
        """A fact to all its users, each with its own FIFO, so that no block waits for another."""
        shape, source = fact.source.payload.shape(), fact.source
        m.submodules[f"{fact.name}_fork"] = fork = Fork(shape, len(fact.routes))
        if fact.registered:
            m.submodules[f"{fact.name}_sent"] = buffer = Buffer(shape)
            connect(m, source, buffer.i)
            source = buffer.o
        connect(m, source, fork.i)
        for way, route in enumerate(fact.routes):
            fifo = self.fact_fifo(m, f"{fact.name}_{route.user}", shape, route.fields)
            connect(m, fork.o[way], fifo.i)
            connect(m, fifo.o, route.sink)

    def fact_fifo(
        self, m: Module, name: str, shape: Any, fields: tuple[str, ...] = (), transfers: int = 1
    ) -> PerFrameFifo:
        """A FIFO for all frames in the core, with so many ``transfers`` each."""
        m.submodules[f"{name}_facts"] = fifo = PerFrameFifo(shape, fields, transfers * self.fact_depth)
        return fifo
