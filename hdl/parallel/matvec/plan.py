"""The products that the matrix-vector unit computes for an estimator: their operands, and what they wait for."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from amaranth import Array, Shape, Value
from amaranth.lib import data

from tfra.hdl.lib.arithmetic import counter_shape, quad
from tfra.hdl.parallel.payloads import operand, vector_quad
from tfra.model.fixed.design import Design


@dataclass(frozen=True)
class Source:
    """A buffer for the operands of some products, behind the port ``name`` of the unit."""

    name: str
    stacks: tuple[str, ...]
    """Stacks of its products, one or two.  With two, the payload has a bit that is set in operands of the second, whose
    name it has."""
    banks: int
    """Operands that it holds, one or two."""
    token: str = ""
    """Name of the tokens that stand for its free banks; none for the codes of frames, which wait for ready instead."""
    bits: int = 0
    """Of a word; 0 for those of a vector."""

    def quads(self, design: Design) -> int:
        """Quads of an operand."""
        return design.stacks[self.stacks[0]].operand_quads

    def payload(self, design: Design) -> Any:
        """Shape of a transfer, where there are tokens."""
        return operand(design, *self.stacks[1:]) if self.stacks[1:] else self.words(design)

    def words(self, design: Design) -> data.ArrayLayout:
        """Shape of a quad: folded codes, or words as long as they may be."""
        if not self.token:
            return quad(design.adc.bits + 2)
        return quad(self.bits) if self.bits else vector_quad(design)

    def flowing(self, design: Design) -> bool:
        """Whether a product may begin with the first quad, because no word of the operand is shifted or rounded.

        So it is for codes if a folded one is no longer than an operand word.
        """
        return not self.token and design.adc.bits + 2 <= design.formats.bits(f"operand.{self.stacks[0]}")


@dataclass(frozen=True)
class Plan:
    """The sources, the one first whose products help the oldest frame, and the tokens that products take.

    ``needs`` has, by stack, the tokens without which a product may not begin, since its results have no place.
    Tokens of a source that no product needs are for the sender of its operands.  ``follows`` has, by the name of a
    token, the stack whose launch gives it: the products that need it come after those of this stack, frame by frame.
    """

    sources: tuple[Source, ...]
    needs: Mapping[str, tuple[str, ...]]
    follows: Mapping[str, str] = field(default_factory=dict)

    def source(self, stack: str) -> Source:
        """Where the operands of a stack come from."""
        return next(source for source in self.sources if stack in source.stacks)

    @property
    def tokens_out(self) -> tuple[str, ...]:
        """Tokens for the senders of operands."""
        needed = {token for tokens in self.needs.values() for token in tokens}
        return tuple(source.token for source in self.sources if source.token and source.token not in needed)

    @property
    def tokens_in(self) -> tuple[str, ...]:
        """Tokens that others give to the unit."""
        own = {source.token for source in self.sources} | set(self.follows)
        return tuple(token for tokens in self.needs.values() for token in tokens if token not in own)


def stack_number(design: Design) -> Shape:
    """Number of a stack in ``design.stacks``."""
    return counter_shape(len(design.stacks) - 1)


def of_number(values: list[int], number: Value) -> Value | int:
    """That of the ``values`` of stacks, or of sources, which has this number; no multiplexer where all are equal."""
    return Array(values)[number] if len(set(values)) > 1 else values[0]
