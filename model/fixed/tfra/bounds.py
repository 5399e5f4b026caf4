"""Integer bits by proof: the largest magnitude of every quantity of TFRA, from the coefficients, for any input."""

from __future__ import annotations

from collections.abc import Mapping

from tfra.model.choices import Choices
from tfra.model.fixed.coefficients import Operator, Stack
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.widths import MU_LIMIT, Widths, force_drop
from tfra.model.tfra import COEFFICIENT_LIMIT


def bounds(choices: Choices, stacks: Mapping[str, Stack]) -> dict[str, dict[str, float]]:
    """Largest magnitudes, in integers of their grids, of the quantities that each field of ``Widths`` has words for.

    Results of a product have the name of their operator, ``normal0`` and ``normal1`` are those of e0 and e1, and
    accumulators that of the operator that they are summed for.  Vectors are folded: four times what taxels hold.
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
    taxel = {"b": b, "c33_inv": product(op["c33_inv"], b)}
    n = taxel["n"] = taxel["c33_inv"] + 1
    taxel |= {name: product(op[name], n) for name in ("c33", "c31", "c32")}
    d0, tangential = b + taxel["c33"], max(taxel["c31"], taxel["c32"])
    e0, e1 = (z + scaled(COEFFICIENT_LIMIT, tangential) for z in (d0, tangential))
    d = e0 + scaled(1, e1)
    taxel |= {"d0": d0, "e0": e0, "e1": e1, "d": d}
    taxel |= {"normal0": product(op["normal"], e0), "normal1": product(op["normal"], e1)}
    p, q = taxel["normal0"] + taxel["c33"], taxel["normal1"]
    taxel |= {"p": p, "q": q} | {o.name: product(o, d) for o in stacks["force"].operators}
    taxel["unscaled"] = max(taxel[o.name] for o in stacks["force"].operators) + scaled(MU_LIMIT, n) + 1
    word = max(lane.values())
    sums = {"sums_b": product(op["sums_b"], b), "sums_n": product(op["sums_n"], n)}
    candidate, longest = 4 * k * (p + q), max(choices.sensor.rows, choices.sensor.columns)
    return {
        "stress": {"stress": code},
        "vector": {**{name: 4 * v for name, v in taxel.items()}, **sums, "sums": sum(sums.values())},
        "accumulator": {name: _row_sum(o) * 2 ** (word - 1) for name, o in op.items()},
        "moment": {"moment": m * longest * code},
        "direction": {"direction": 2 * m * longest * code * m * code},
        "candidate": {"candidate": candidate},
        "b_z": {"b_z": m * candidate},
        "b_xy": {"b_xy": m * (candidate + 4 * k * b)},
        "force": {"force": 4 * taxel["unscaled"] / 2 ** force_drop(choices) + 1},
        "magnitude": {"magnitude": m * code},
    }


def _row_sum(operator: Operator) -> float:
    return float(abs(operator.rows).sum(axis=-1).max())


def make_widths(choices: Choices, stacks: Mapping[str, Stack]) -> Widths:
    """Word lengths of a core with these ``choices`` and coefficients.

    Raises ``ValueError`` naming ``formats``, or ``sensor``, when exact integers would not fit the 63 bits that the
    model can hold, that is when the formats could overflow.
    """
    fmt, m = choices.formats, choices.sensor.taxels
    most = {name: max(quantities.values()) for name, quantities in bounds(choices, stacks).items()}
    vector = signed_bits(most["vector"] + 4)
    fractions = [o.fraction for s in stacks.values() for o in s.operators]
    word = max(fmt.bits(f"operand.{name}") for name in stacks)
    result = Widths(
        stress=choices.adc.bits,
        vector=vector,
        accumulator=signed_bits(most["accumulator"]),
        alignment=max(0, *(vector - word - fraction for fraction in fractions)),
        moment=int(most["moment"]).bit_length(),
        direction=signed_bits(most["direction"]),
        candidate=signed_bits(most["candidate"]),
        b_z=int(most["b_z"]).bit_length(),
        b_xy=int(most["b_xy"]).bit_length(),
        force=vector - force_drop(choices),
        magnitude=int(most["magnitude"]).bit_length(),
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
