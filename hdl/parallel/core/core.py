"""The frame of a parallel core: its ports, its blocks, and the facts of a frame on their way between them."""

import gc
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple, TypeVar

from amaranth import Cat, Const, Module, Signal, Value, signed
from amaranth.hdl import UnusedElaboratable
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.lib.streams import Buffer, Fork, PerFrameFifo

T = TypeVar("T")

PLACES = (0, 1, 2, 3)
"""The words of a quad."""


class CoreBlocks:
    """A base of classes whose attributes are blocks, set in dataflow order and named as their instances."""

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return iter(vars(self).items())


def ask_blocks(build: Callable[[], CoreBlocks], ask: Callable[[CoreBlocks], T]) -> T:
    """What ``ask`` finds in blocks that are never elaborated."""
    gc.freeze()  # so that the collection below looks at nothing but the blocks
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnusedElaboratable)
            blocks = build()
            answer = ask(blocks)
            del blocks
            gc.collect()  # a block that was never elaborated warns when it is deleted: delete it here
    finally:
        gc.unfreeze()
    return answer


class Watched(NamedTuple):
    """A stream of a block that a simulation may watch: see :class:`tfra.hdl.interface.microarchitecture.Probe`."""

    stage: str
    """Name of the block, too."""
    port: str
    """With the member of its payload, if it is one."""
    keys: tuple[int | str, ...]
    transfers: int = 1

    def words(self, block: Any) -> list[Value]:
        """The payload's members of these keys, or all of it."""
        port, _, member = self.port.partition(".")
        payload = getattr(block, port).payload
        payload = payload[member] if member else payload
        return [Value.cast(payload[key]) for key in self.keys] or [Value.cast(payload)]

    def probe(self, block: Any) -> Probe:
        """The same with the shapes of the words."""
        shapes = [word.shape() for word in self.words(block)]
        words = tuple((shape.width, shape.signed) for shape in shapes)
        return Probe(self.stage, self.port, self.keys, words, self.transfers)


@dataclass(frozen=True)
class Fact:
    """A fact of a frame that one block computes and others use: one transfer a frame to every user.

    ``source`` is "BLOCK.FACT".  A user is a block with a port of the fact's name, or "BLOCK.PORT"; it reads the fields
    behind its name, or all if there are none.
    """

    source: str
    users: Mapping[str, tuple[str, ...]]
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
    def watched(design: Any) -> Sequence[Watched]:
        """Streams that a simulation may watch, in the order in which data reach them, if their blocks are there."""

    @classmethod
    def watched_blocks(cls, design: Any, blocks: CoreBlocks) -> list[tuple[Watched, Any]]:
        """Each of these streams with its block."""
        by_name = dict(blocks)
        return [(each, by_name[each.stage]) for each in cls.watched(design) if each.stage in by_name]

    @abstractmethod
    def wire(self, m: Module, blocks: Any) -> None:
        """Connect the blocks with each other and with ``result``."""

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        blocks = self.blocks(self.design)
        for name, block in blocks:
            m.submodules[name] = block
        self.wire(m, blocks)
        for each, block in self.watched_blocks(self.design, blocks):
            self._add_probe(m, each, block)
        return m

    @staticmethod
    def _add_probe(m: Module, watched: Watched, block: Any) -> None:
        """Name a stream; nothing depends on it, so it costs no hardware."""
        members, port = Cat(watched.words(block)), getattr(block, watched.port.partition(".")[0])
        transfer = Signal(name=f"probe_{watched.stage}")
        words = Signal(len(members), name=f"probe_{watched.stage}_words")
        m.d.comb += transfer.eq(port.valid & port.ready)
        m.d.comb += words.eq(members)

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

    def wire_fact(self, m: Module, blocks: CoreBlocks, fact: Fact) -> None:
        """A fact to all its users, each with its own FIFO, so that no block waits for another."""
        source, name = attrgetter(fact.source)(blocks), fact.source.partition(".")[2]
        shape = source.payload.shape()
        m.submodules[f"{name}_fork"] = fork = Fork(shape, len(fact.users))
        if fact.registered:
            m.submodules[f"{name}_sent"] = buffer = Buffer(shape)
            connect(m, source, buffer.i)
            source = buffer.o
        connect(m, source, fork.i)
        for way, (user, fields) in enumerate(fact.users.items()):
            block, _, port = user.partition(".")
            fifo = self.fact_fifo(m, f"{name}_{user.replace('.', '_')}", shape, fields)
            connect(m, fork.o[way], fifo.i)
            connect(m, fifo.o, getattr(getattr(blocks, block), port or name))

    def fact_fifo(
        self, m: Module, name: str, shape: Any, fields: tuple[str, ...] = (), transfers: int = 1
    ) -> PerFrameFifo:
        """A FIFO for all frames in the core, with so many ``transfers`` each."""
        m.submodules[f"{name}_facts"] = fifo = PerFrameFifo(shape, fields, transfers * self.fact_depth)
        return fifo
