"""Integer bits by proof: the largest magnitude of every quantity of TFRA, from the coefficients, for any input."""

from __future__ import annotations

from collections.abc import Mapping

from tfra.model.choices import Choices
from tfra.model.fixed.coefficients import Operator, Stack
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.widths import MU_LIMIT, Widths, force_drop
from tfra.model.tfra import COEFFICIENT_LIMIT


def make_widths(choices: Choices, stacks: Mapping[str, Stack]) -> Widths:
    """Word lengths of a core with these ``choices`` and coefficients.

    Raises ``ValueError`` naming ``formats``, or ``sensor``, when exact integers would not fit the 63 bits that the
    model can hold, that is when the formats could overflow.
    """
    fmt, m, k, code = choices.formats, choices.sensor.taxels, choices.search.steps, 2 ** (choices.adc.bits - 1)
    stack = {o.name: s.name for s in stacks.values() for o in s.operators}
    op = {o.name: o for s in stacks.values() for o in s.operators}
    lane = {name: fmt.bits(f"operand.{stack[name]}") for name in op}

    def product(operator: Operator, taxel: float) -> float:
        """Bound of a product's results in the taxel domain, operand rounding and result rounding included."""
        slack = 2.0 ** (2 - lane[operator.name])
        return (operator.gain + 4 * slack * operator.folded_gain) * taxel + 2

    def scaled(limit: float, taxel: float) -> float:
        """Bound of a vector times a scalar of at most ``limit``: ``taxel`` as a rounded operand, result rounding."""
        return limit * (1 + 2.0 ** (3 - fmt.bits("operand.combine"))) * taxel + 1

    b = float(code << fmt.vector_fraction)
    n = product(op["c33_inv"], b) + 1
    g, d1, d2 = (product(op[name], n) for name in ("c33", "c31", "c32"))
    d0, tangential = b + g, max(d1, d2)
    e0, e1 = (z + scaled(COEFFICIENT_LIMIT, tangential) for z in (d0, tangential))
    d = e0 + scaled(1, e1)
    p, q = product(op["normal"], e0) + g, product(op["normal"], e1)
    force = max(product(o, d) for o in stacks["force"].operators)
    unscaled = force + scaled(MU_LIMIT, n) + 1
    sums = product(op["sums_b"], b) + product(op["sums_n"], n)
    vector = signed_bits(max(4 * max(b, n, d0, d1, d2, e0, e1, d, p, q, unscaled), sums) + 4)
    word = max(lane.values())
    row_sum = max(float(abs(o.rows).sum(axis=-1).max()) for o in op.values())
    candidate = 4 * k * (p + q)
    longest = max(choices.sensor.rows, choices.sensor.columns)
    result = Widths(
        stress=choices.adc.bits,
        vector=vector,
        accumulator=signed_bits(row_sum * 2 ** (word - 1)),
        alignment=max(0, *(vector - word - o.fraction for o in op.values())),
        moment=(m * longest * code).bit_length(),
        direction=signed_bits(2 * m * longest * code * m * code),
        candidate=signed_bits(candidate),
        b_z=int(m * candidate).bit_length(),
        b_xy=int(m * (candidate + 4 * k * b)).bit_length(),
        force=vector - force_drop(choices),
        magnitude=(m * code).bit_length(),
        division=fmt.bits("division"),
        output=choices.adc.bits + (m - 1).bit_length() + fmt.force_fraction,
    )
    _check(result, fmt.bits("scalar"))
    return result


def _check(widths: Widths, scalar: int) -> None:
    """Raise where the model's integers would overflow, products by words of ``scalar`` bits included."""
    longest_word = {
        "direction": widths.direction,
        "b_xy": widths.b_xy + 1,
        "accumulator": widths.accumulator + widths.alignment + 1,
        "force": widths.force + scalar + 1,
    }
    for name, bits in longest_word.items():
        if bits > 63:
            key = "sensor" if name == "direction" else "formats"
            raise ValueError(f"{key}: {name} can overflow: {bits} bits are needed, 63 are supported")
