"""Rounding and overflow: named values, which the model, the gateware and the sidecar share.

Another rounding is one member here, its line in :func:`tfra.model.fixed.numbers.round_shift`, its line in
:func:`tfra.hdl.lib.arithmetic.round_off`, and its row in ``tests/model/fixed/test_numbers.py``.
"""

from enum import StrEnum


class Rounding(StrEnum):
    """How ``x / 2^drop`` becomes an integer.  Words and vectors are rounded half up unless a block says otherwise."""

    HALF_UP = "half_up"
    """``floor(x / 2^drop + 1/2)``: to nearest, ties towards plus infinity."""
    HALF_EVEN = "half_even"
    """To nearest, ties to the even integer."""
    TRUNCATE = "truncate"
    """Towards minus infinity: bits are cut off."""

    @property
    def sticky(self) -> bool:
        """Whether any bit below the highest one that is cut off matters, not that one alone."""
        return self is Rounding.HALF_EVEN

    def constant(self, drop: int) -> int:
        """What rounds when it is added before ``drop`` bits are cut off, for adders that sum something else as well.

        Raises ``ValueError`` for a mode where it depends on the word.
        """
        if self.sticky:
            raise ValueError(f"rounding: {self} adds no constant")
        return 1 << drop >> 1 if self is Rounding.HALF_UP else 0


class Overflow(StrEnum):
    """What becomes of a result that its word does not hold."""

    SATURATE = "saturate"
    """The nearest word."""
    WRAP = "wrap"
    """The low bits: a counter or an angle begins again."""
    NEVER = "never"
    """It does not occur: the word is long enough by proof."""
