"""Integer bits by proof: the largest magnitude of every quantity of TFRA, from the coefficients, for any input."""

from collections.abc import Mapping

from tfra.model.choices import Choices
from tfra.model.fixed.coefficients import Operator, Stack
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.widths import LONGEST, MU_LIMIT, Widths, force_drop, require_exact, widths_of
from tfra.model.tfra import COEFFICIENT_LIMIT


def bounds(choices: Choices, stacks: Mapping[str, Stack]) -> dict[str, dict[str, float]]:
    """Largest magnitudes, in integers of their grids, of the quantities that each field of ``Widths`` has words for.

    Results of a product have the name of their operator, ``normal0`` and ``normal1`` are those of e0 and e1, and
    accumulators that of the operator that they are summed for.
    """
    fmt, sensor = choices.formats, choices.sensor
    m, k, code = sensor.taxels, choices.search.steps, 2 ** (choices.adc.bits - 1)
    operators = {o.name: o for s in stacks.values() for o in s.operators}
    lane = {o.name: fmt.bits(f"operand.{s.name}") for s in stacks.values() for o in s.operators}
    taxel = _taxel_bounds(choices, stacks, operators, lane)
    sums_b = _product(operators["sums_b"], lane["sums_b"], taxel["b"])
    sums_n = _product(operators["sums_n"], lane["sums_n"], taxel["n"])
    folded = {name: 4 * bound for name, bound in taxel.items()}  # a parity adds four mirror taxels
    operand = 2 ** (max(lane.values()) - 1)  # the largest word of the longest operand
    moment = m * max(sensor.rows, sensor.columns) * code  # every taxel at full scale, in the farthest column
    candidate = 4 * k * (taxel["p"] + taxel["q"])  # K p + kappa q with |kappa| <= K, unfolded: times four
    return {
        "stress": {"stress": code},
        "vector": {**folded, "sums_b": sums_b, "sums_n": sums_n, "sums": sums_b + sums_n},
        "accumulator": {name: float(o.row_sum * operand) for name, o in operators.items()},
        "moment": {"moment": moment},
        "direction": {"direction": 2 * moment * m * code},  # a difference of two moments times sums
        "candidate": {"candidate": candidate},
        "b_z": {"b_z": m * candidate},
        "b_xy": {"b_xy": m * (candidate + 4 * k * taxel["b"])},  # the traction is the stress less the candidate
        "force": {"force": folded["unscaled"] / 2 ** force_drop(choices) + 1},  # bits are dropped, and the rest rounded
        "magnitude": {"magnitude": m * code},
    }


def _taxel_bounds(
    choices: Choices, stacks: Mapping[str, Stack], operators: Mapping[str, Operator], lane: Mapping[str, int]
) -> dict[str, float]:
    """Bounds of vectors at a taxel, in the order of the dataflow."""

    def product(name: str, operand: float) -> float:
        return _product(operators[name], lane[name], operand)

    def scaled(limit: float, operand: float) -> float:
        """A scalar of at most ``limit`` times a vector, which is rounded as an operand; the result is rounded, too."""
        return limit * (1 + 2.0 ** (3 - choices.formats.bits("operand.combine"))) * operand + 1

    forces = [o.name for o in stacks["force"].operators]
    bound = {"b": float(2 ** (choices.adc.bits - 1) << choices.formats.vector_fraction)}
    bound["c33_inv"] = product("c33_inv", bound["b"])
    bound["n"] = bound["c33_inv"] + 1  # its quarter is rounded
    for name in ("c33", "c31", "c32"):
        bound[name] = product(name, bound["n"])
    tangential = max(bound["c31"], bound["c32"])  # either may be that of mu_ind
    bound["d0"] = bound["b"] + bound["c33"]
    bound["e0"] = bound["d0"] + scaled(COEFFICIENT_LIMIT, tangential)  # |alpha|, |beta| are limited
    bound["e1"] = tangential + scaled(COEFFICIENT_LIMIT, tangential)
    bound["d"] = bound["e0"] + scaled(1, bound["e1"])  # |mu_ind| <= 1
    bound["normal0"] = product("normal", bound["e0"])
    bound["normal1"] = product("normal", bound["e1"])
    bound["p"] = bound["normal0"] + bound["c33"]
    bound["q"] = bound["normal1"]
    for name in forces:
        bound[name] = product(name, bound["d"])
    bound["unscaled"] = max(bound[name] for name in forces) + scaled(MU_LIMIT, bound["n"]) + 1
    return bound


def _product(operator: Operator, lane: int, operand: float) -> float:
    """Bound of a product's results at a taxel: the operand, of ``lane`` bits, and the result are rounded."""
    slack = 2.0 ** (2 - lane)  # of a folded operand word: it is rounded, relative to its parity's largest
    return (operator.gain + 4 * slack * operator.folded_gain) * operand + 2


def make_widths(choices: Choices, stacks: Mapping[str, Stack]) -> Widths:
    """Word lengths of a core with these ``choices`` and coefficients.

    Raises ``ValueError`` naming ``formats``, or ``sensor``, when exact integers would not fit the 63 bits that the
    model can hold, that is when the formats could overflow.
    """
    most = {name: max(quantities.values()) for name, quantities in bounds(choices, stacks).items()}
    vector = signed_bits(most["vector"] + 4)
    direction = signed_bits(most["direction"])
    if direction > LONGEST:
        raise ValueError(f"sensor: direction can overflow: {direction} bits are needed, {LONGEST} are supported")
    result = widths_of(
        choices,
        stacks,
        vector,
        moment=int(most["moment"]).bit_length(),
        direction=direction,
        candidate=signed_bits(most["candidate"]),
        b_z=int(most["b_z"]).bit_length(),
        b_xy=int(most["b_xy"]).bit_length(),
        force=vector - force_drop(choices),
    )
    require_exact(result, choices.formats.bits("scalar"), b_xy=result.b_xy + 1)
    return result
