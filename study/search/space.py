"""The search space: which word lengths, lanes and steps a search may choose, and the design that a choice makes."""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from tfra.model.fixed.design import Design

Point = Mapping[str, int]
"""One option for each name of a space."""

_FORMATS = ("coefficient", "operand", "vector_fraction", "force_fraction")
_ARCHITECTURE = ("mac_lanes", "vector_words")


def names(base: Design) -> tuple[str, ...]:
    """Choices of a search: formats, signals of ``base``, the parallelism of the core, steps of a sweep."""
    return (*_FORMATS, *base.used_signals, *_ARCHITECTURE, *(["steps"] if base.sweeps else []))


@dataclass(frozen=True)
class Space:
    """``options``: the values of each of the ``names`` that is searched, ascending.

    Raises ``ValueError`` that starts with the name for invalid options.
    """

    options: Mapping[str, tuple[int, ...]]

    def __post_init__(self) -> None:
        if not self.options:
            raise ValueError("space: at least one name to choose is needed")
        for name, options in self.options.items():
            if not options or list(options) != sorted(set(options)):
                raise ValueError(f"{name}: options in rising order are needed, got {list(options)}")

    def require_of(self, base: Design) -> None:
        """Raise ``ValueError`` that starts with a name that ``base`` does not have."""
        known = names(base)
        for name in self.options:
            if name not in known:
                nearest = difflib.get_close_matches(name, known, n=1, cutoff=0)[0]
                raise ValueError(f"{name}: unknown signal, the nearest is {nearest}")

    def point(self, indices: Mapping[str, int]) -> dict[str, int]:
        """The point with these indices of the options."""
        return {name: options[indices[name]] for name, options in self.options.items()}

    @staticmethod
    def uniform(base: Design, bits: int) -> Point:
        """Coefficients and operands of ``bits`` each; the operand of single values is at least as long as the codes."""
        operands = {name: bits for name in base.used_signals if name.startswith("operand.")}
        fraction = base.formats.vector_fraction + max(0, bits - base.formats.operand)
        return {
            "coefficient": bits,
            "operand": max(bits, base.adc.bits),
            **(operands if bits < base.adc.bits else {}),
            "vector_fraction": min(16, fraction),
        }

    @classmethod
    def around(cls, base: Design, bits: int, free: int) -> "Space":
        """Lengths of coefficients, operands, vectors and single values, if ``bits`` are enough for all products.

        Up to two bits more, if a multiplier takes them at no cost, that is up to ``free`` bits, and down to seven bits
        less; single values are at least as long as the codes, and no longer than in ``base``.
        """
        lanes = tuple(range(max(6, bits - 7), max(bits, min(bits + 2, free)) + 1))
        fraction = base.formats.vector_fraction
        return cls({
            **{name: lanes for name in base.used_signals if name.startswith(("coefficient.", "operand."))},
            "operand": tuple(range(base.adc.bits, base.formats.operand + 1)),
            "vector_fraction": tuple(range(max(0, fraction - 7), fraction + 1)),
        })  # fmt: skip

    @staticmethod
    def design(base: Design, point: Point) -> Design:
        """``base`` with the point's choices.

        Raises ``ValueError`` as :class:`tfra.model.choices.Choices` does where they do not fit together, and where
        words could overflow.
        """
        formats = base.formats
        own = dict(formats.signals) | {name: bits for name, bits in point.items() if name in base.signals}
        chosen: dict[str, Any] = {name: point[name] for name in _FORMATS if name in point}
        parallelism: dict[str, Any] = {name: point[name] for name in _ARCHITECTURE if name in point}
        design = replace(
            base,
            formats=replace(formats, name="custom", signals=tuple(own.items()), **chosen),
            architecture=replace(base.architecture, **parallelism),
            search=replace(base.search, steps=point.get("steps", base.search.steps)),
        )
        _ = design.widths
        return design
