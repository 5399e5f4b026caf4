"""Integer bits by proof: the largest magnitude of every quantity of the learned estimator, for any input."""

from __future__ import annotations

from collections.abc import Mapping

from tfra.model.choices import Choices
from tfra.model.fixed.coefficients import Operator, Stack
from tfra.model.fixed.learned.resultant import THRESHOLD_BITS
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.widths import Widths
from tfra.model.learned.field import MOST_FRICTION
from tfra.model.learned.weights import MIRRORS

LONGEST = 63
"""Bits of the model's integers."""


def bounds(choices: Choices, stacks: Mapping[str, Stack]) -> dict[str, float]:
    """Largest magnitudes of taxels and mirrors on the vector grid, and of the exact sums of a row.

    A folded vector is four times as large at most; a result in front of a butterfly is no larger than what the
    butterfly makes of it.
    """
    fmt = choices.formats
    op = {o.name: o for s in stacks.values() for o in s.operators}
    lane = {o.name: fmt.bits(f"operand.{s.name}") for s in stacks.values() for o in s.operators}

    def rounded(gain: float, operator: Operator) -> float:
        """Gain of an operator whose operand is rounded by at most two units of its word."""
        return gain + 4 * operator.folded_gain * 2.0 ** (4 - lane[operator.name])

    def mirror(name: str, taxel: float) -> float:
        """Bound of the words that a butterfly makes of the results of an operator."""
        return rounded(MIRRORS * op[name].gain, op[name]) * taxel + MIRRORS

    def output(name: str, taxel: float) -> float:
        """Bound of results that no butterfly follows."""
        return rounded(MIRRORS * op[name].folded_gain, op[name]) * taxel + 1

    b = 2.0 ** (choices.adc.bits - 1 + fmt.vector_fraction)
    h1 = mirror("first", b)
    h2 = mirror("second", h1)
    found = {"b": b, "h1": h1, "h2": h2}
    found["outputs"] = output("direct", b) + output("read1", h1) + output("read2", h2)
    if "inverse" in op:
        p0 = mirror("inverse", b)
        sheared = mirror("shear_x", p0) + mirror("shear_y", p0)
        found |= {"p0": p0, "sheared": sheared}
        found["p"] = p0 + MOST_FRICTION * (1 + 2.0 ** (4 - fmt.bits("operand.combine"))) * sheared + 2 * MIRRORS
    return found


def make_widths(choices: Choices, stacks: Mapping[str, Stack]) -> Widths:
    """Word lengths of a core with these ``choices`` and coefficients.

    Raises ``ValueError`` naming ``formats`` when exact integers would not fit the 63 bits that the model can hold.
    """
    fmt, m = choices.formats, choices.sensor.taxels
    most = bounds(choices, stacks)
    folded = MIRRORS * max(value for name, value in most.items() if name != "outputs")
    vector = signed_bits(max(folded, most["outputs"]))
    operators = [o for s in stacks.values() for o in s.operators]
    word = max(fmt.bits(f"operand.{name}") for name in stacks)
    largest = max(float(abs(o.rows).sum(axis=-1).max()) for o in operators)
    result = Widths(
        stress=choices.adc.bits,
        vector=vector,
        accumulator=signed_bits(largest * 2 ** (word - 1)),
        alignment=max(0, *(vector - word - o.fraction for o in operators)),
        force=signed_bits(most.get("p", 0.0)),
        magnitude=int(m * 2 ** (choices.adc.bits - 1)).bit_length(),
        division=fmt.bits("division"),
        output=choices.adc.bits + (m - 1).bit_length() + fmt.force_fraction,
    )
    longest_word = {
        "accumulator": result.accumulator + result.alignment + 1,
        "force": result.force + fmt.bits("scalar") + 1,
        "total": total_bits(choices, result) + fmt.bits("scalar"),
        "uncertainty": result.vector + THRESHOLD_BITS + 1,
    }
    for name, bits in longest_word.items():
        if bits > LONGEST:
            raise ValueError(f"formats: {name} can overflow: {bits} bits are needed, {LONGEST} are supported")
    return result


def total_bits(choices: Choices, widths: Widths) -> int:
    """Bits of the unsigned sum of all taxels' forces."""
    return widths.force - 1 + (choices.sensor.taxels - 1).bit_length()
