"""Signals with word lengths of their own: what each follows, what it changes, what does not fit together."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.hdl.parallel.designs import mixed_design
from tests.model.cases import make_design
from tfra.model.choices import FORMATS, SCALARS, SERIAL, Formats
from tfra.model.cover.scenes import SENSORS, contact_codes, directed_codes
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.tfra.design import SIGNALS, TfraDesign
from tfra.model.rounding import Rounding

SENSOR = SENSORS["4×6, 5×3 mm, h 2 mm"]
STANDARD = FORMATS["standard"]


def own(**signals: int) -> Formats:
    """Standard formats with some signals' own lengths; ``__`` stands for the point."""
    return replace(STANDARD, name="own", signals=tuple((name.replace("__", "."), n) for name, n in signals.items()))


def test_signals_follow_coefficients_and_operands() -> None:
    formats = Formats("uneven", 14, 16, 9, 4, (("operand.force", 12), ("coefficient.normal", 11)))
    found = {name: formats.bits(name) for name in SIGNALS}
    assert found.pop("operand.force") == 12
    assert found.pop("coefficient.normal") == 11
    assert found.pop("division") == 20
    assert {found[name] for name in found if name.startswith("coefficient.")} == {14}
    assert {found[name] for name in found if not name.startswith("coefficient.")} == {16}


def test_the_order_of_signals_does_not_matter() -> None:
    assert own(sums=16, cordic=20) == own(cordic=20, sums=16)
    assert hash(own(sums=16, cordic=20)) == hash(own(cordic=20, sums=16))


def test_lengths_that_are_written_out_change_nothing() -> None:
    design = make_design(SENSOR)
    written = replace(STANDARD, signals=tuple((name, STANDARD.bits(name)) for name in SIGNALS))
    codes = contact_codes(design, 50, seed=1)
    assert (replace(design, formats=written).model(codes).words == design.model(codes).words).all()


def test_the_page_tells_all_of_them() -> None:
    page = (Path(__file__).parents[3] / "docs" / "numerics.md").read_text()
    for name, what in SCALARS.items():
        assert f"| `{name}` | {what} |" in page
    for name in SIGNALS:
        assert f"`{name.rpartition('.')[2]}`" in page


@pytest.mark.parametrize("signal", SIGNALS)
def test_each_signal_is_somebodys(signal: str) -> None:
    """Three bits less are seen in what flows out of some block."""
    design = make_design(SENSOR)
    length = STANDARD.bits(signal) - 3
    lengths = {signal: length, **({"scalar": length} if signal == "cordic" else {})}
    shorter = replace(design, formats=replace(STANDARD, name="shorter", signals=tuple(lengths.items())))
    codes = contact_codes(design, 50, seed=2)
    found, plain = shorter.model(codes).stages, design.model(codes).stages
    assert any((found[stage] != plain[stage]).any() for stage in plain)


@pytest.mark.parametrize("name", [name for name in SIGNALS if name.startswith("coefficient.")])
def test_an_operators_coefficients_have_its_length(name: str) -> None:
    """They stand at the top of a lane's word, and are those of a design that has this length everywhere."""
    plain, formats = make_design(SENSOR), replace(STANDARD, name="own", signals=((name, 12),))
    design, short = replace(plain, formats=formats), replace(plain, formats=replace(STANDARD, coefficient=12))
    for stack, others in design.stacks.items():
        for operator, long, twelve in zip(
            others.operators, plain.stacks[stack].operators, short.stacks[stack].operators, strict=True
        ):
            if f"coefficient.{operator.name}" == name:
                assert (operator.rows == twelve.rows << 6).all()
                assert operator.fraction == twelve.fraction + 6
                assert operator.gain == twelve.gain
            else:
                assert (operator.rows == long.rows).all()
    words = {f"coefficient.{op.name}": op.rows.size for stack in design.stacks.values() for op in stack.operators}
    assert design.coefficient_bits == 18 * sum(words.values()) - 6 * words[name]
    assert design.coefficient_word == 18


def test_lanes_are_as_wide_as_the_longest() -> None:
    lanes = {name: 12 for name in SIGNALS if name.startswith(("coefficient.", "operand."))} | {"operand.combine": 24}
    formats = replace(STANDARD, name="own", signals=tuple(lanes.items()))
    design = replace(make_design(SENSOR), formats=formats)
    assert (design.coefficient_word, design.operand_word) == (12, 12)


@pytest.mark.parametrize("seed", range(12))
def test_extremes_stay_within_the_bounds_of_mixed_lengths(seed: int) -> None:
    design = mixed_design(seed)
    top, rng = 1 << (design.adc.bits - 1), np.random.default_rng(seed)
    codes = rng.choice([-top, top - 1], size=(200, design.sensor.rows, design.sensor.columns))
    stages = design.model(np.concatenate([codes, directed_codes(design)])).stages
    for key in ("matvec", "weights", "combine"):
        assert signed_bits(float(np.abs(stages[key]).max())) <= design.widths.vector, key
    for key, bits in (("centroids", "direction"), ("dependent", "scalar"), ("friction", "scalar")):
        assert signed_bits(float(np.abs(stages[key]).max())) <= design.formats.bits(bits) + 1, key


@pytest.mark.parametrize(
    ("signals", "line"),
    [
        ({"sums": 9}, "signals.sums: 10 to 27 bits are supported, got 9"),
        ({"sums": 28}, "signals.sums: 10 to 27 bits are supported, got 28"),
        ({"division": 32}, "signals.division: 10 to 31 bits are supported, got 32"),
        ({"direction": 24}, "signals.division: at least 24 bits are needed beside the 24 of direction, got 22"),
        ({"division": 18}, "signals.division: at least 19 bits are needed beside the 18 of cordic, got 18"),
        ({"cordic": 17}, "signals.cordic: at least 18 bits are needed beside the 18 of scalar, got 17"),
        (
            {"sums": 10, "direction": 12},
            "signals.division: at most 21 bits, those of sums and direction less one, are supported, got 22",
        ),
    ],
)
def test_lengths_that_do_not_fit_together(signals: dict[str, int], line: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(line)}$"):
        own(**signals)


def test_an_unknown_signal() -> None:
    line = "formats.signals.operand.forces: unknown signal, the nearest is operand.force"
    with pytest.raises(ValueError, match=f"^{line}$"):
        TfraDesign(SENSOR, formats=own(operand__forces=12))


def test_a_serial_core_has_one_length_for_all_and_rounds_half_up() -> None:
    with pytest.raises(ValueError, match=r"^formats.signals.sums: a serial core has one multiplier and one memory"):
        TfraDesign(SENSOR, formats=own(sums=16), architecture=SERIAL)
    with pytest.raises(ValueError, match=r"^formats.rounding: the adder of a serial core rounds half up"):
        TfraDesign(SENSOR, formats=replace(own(), rounding=Rounding.TRUNCATE), architecture=SERIAL)
