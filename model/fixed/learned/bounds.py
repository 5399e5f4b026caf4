"""Integer bits by proof: the largest magnitude of every quantity of the learned estimator, for any input."""

from collections.abc import Mapping

from tfra.model.choices import Choices
from tfra.model.fixed.coefficients import Operator, Stack
from tfra.model.fixed.learned.resultant import THRESHOLD_BITS
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.widths import Widths, require_exact, widths_of
from tfra.model.learned.field import MOST_FRICTION
from tfra.model.learned.network import MIRRORS


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

    bound = {"b": 2.0 ** (choices.adc.bits - 1 + fmt.vector_fraction)}
    bound["h1"] = mirror("first", bound["b"])
    bound["h2"] = mirror("second", bound["h1"])
    bound["outputs"] = output("direct", bound["b"]) + output("read1", bound["h1"]) + output("read2", bound["h2"])
    if "inverse" in op:
        scaled = MOST_FRICTION * (1 + 2.0 ** (4 - fmt.bits("operand.combine")))  # the scalar times a rounded operand
        bound["p0"] = mirror("inverse", bound["b"])
        bound["sheared"] = mirror("shear_x", bound["p0"]) + mirror("shear_y", bound["p0"])
        bound["p"] = bound["p0"] + scaled * bound["sheared"] + 2 * MIRRORS  # two results, each rounded at four mirrors
    return bound


def make_widths(choices: Choices, stacks: Mapping[str, Stack]) -> Widths:
    """Word lengths of a core with these ``choices`` and coefficients.

    Raises ``ValueError`` naming ``formats`` when exact integers would not fit the 63 bits that the model can hold.
    """
    most, scalar = bounds(choices, stacks), choices.formats.bits("scalar")
    folded = MIRRORS * max(bound for name, bound in most.items() if name != "outputs")
    vector = signed_bits(max(folded, most["outputs"]))
    result = widths_of(choices, stacks, vector, force=signed_bits(most.get("p", 0.0)))
    total = total_bits(choices, result) + scalar
    require_exact(result, scalar, total=total, uncertainty=vector + THRESHOLD_BITS + 1)
    return result


def total_bits(choices: Choices, widths: Widths) -> int:
    """Bits of the unsigned sum of all taxels' forces."""
    return widths.force - 1 + (choices.sensor.taxels - 1).bit_length()
