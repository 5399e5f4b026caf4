"""Variations of word lengths, of the converter, of the search: each changes what its facts say and nothing else."""

from dataclasses import replace

import pytest

from tests.model.cases import make_design
from tests.model.fixed.learned.cases import learned_design
from tfra.families import DEFAULT, find
from tfra.model.choices import SERIAL, Adc, Architecture, Search
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import SIGNALS, TfraDesign
from tfra.model.rounding import Rounding
from tfra.study.errors.cascade import Step
from tfra.study.errors.comparisons import FRACTIONS, behind, converters, sensitivity, uniform, variants
from tfra.study.search.costs import coefficient_kbit, dsp, multiplier_kbit, products
from tfra.study.search.space import Space
from tfra.synth.estimate import estimate

BASE = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])


def test_each_signal_is_shortened_alone() -> None:
    found = sensitivity(BASE, DEFAULT, (1, 2, 4))
    assert [(each.facts["signal"], each.facts["shorter"]) for each in found] == [
        (signal, shorter) for signal in (*SIGNALS, *FRACTIONS) for shorter in (1, 2, 4)
    ]
    for each in found:
        if each.design is None:
            assert each.reason
            assert each.facts["coefficient_kbit"] is None
            continue
        signal, formats = str(each.facts["signal"]), each.design.formats
        if signal in FRACTIONS:
            assert each.facts["bits"] == getattr(BASE.formats, signal) - each.facts["shorter"]
            assert formats == replace(BASE.formats, name=formats.name, **{signal: each.facts["bits"]})
        else:
            others = {name: formats.bits(name) for name in SIGNALS if name != signal}
            assert others == {name: BASE.formats.bits(name) for name in SIGNALS if name != signal}
            assert formats.bits(signal) == each.facts["bits"] == BASE.formats.bits(signal) - each.facts["shorter"]
        assert each.facts["coefficient_kbit"] == each.design.coefficient_bits / 1000


def test_uniform_designs_have_one_length() -> None:
    base = replace(BASE, formats=replace(BASE.formats, signals=(("sums", 20),)))
    short, long = uniform(base, (12, 20), DEFAULT)
    assert short.design is not None
    assert long.design is not None
    lanes = {name for name in SIGNALS if name.startswith(("coefficient.", "operand."))}
    assert {short.design.formats.bits(name) for name in lanes} == {12}
    assert {short.design.formats.bits(name) for name in set(SIGNALS) - lanes} == {14, 18}  # a 14-bit converter
    assert {long.design.formats.bits(name) for name in SIGNALS} == {20, 24}
    fractions = [design.formats.vector_fraction for design in (short.design, long.design)]
    assert fractions == [BASE.formats.vector_fraction, BASE.formats.vector_fraction + 2]
    assert [e.facts["vector_fraction"] for e in (short, long)] == fractions


def test_converters_differ_in_bits_and_noise_alone() -> None:
    found = converters(BASE, (8, 12, 16), (0.0, 0.002))
    assert [(e.facts["noise_share_of_peak"], e.facts["bits"]) for e in found] == [
        (n, b) for n in (0.0, 0.002) for b in (8, 12, 16)
    ]
    for each in found:
        assert each.design is not None
        assert each.noise == each.facts["noise_share_of_peak"]
        assert each.design.adc.bits == each.facts["bits"]
        assert replace(each.design, adc=BASE.adc, search=BASE.search) == BASE
        assert each.compared == (Step.NOISE, Step.CONVERTER, Step.ARITHMETIC)


def test_threshold_and_tolerance_stay_as_stress() -> None:
    base = replace(BASE, adc=Adc(14, 200e3, 64), search=Search(100, 4.0))
    found = behind(base, 12)
    assert (found.adc, found.search) == (Adc(12, 200e3, 16), Search(100, 1.0))
    assert found.adc.threshold * found.adc.lsb == base.adc.threshold * base.adc.lsb
    assert found.search.tolerance * found.adc.lsb == base.search.tolerance * base.adc.lsb


def test_variants_of_the_search_and_of_rounding() -> None:
    found = variants(BASE, (10, 500), (0.0, 0.3, 3.0))
    assert [each.facts["variant"] for each in found] == [
        *["steps"] * 2, *["plateau_tolerance"] * 3, *["rounding"] * len(Rounding)
    ]  # fmt: skip
    for each in found:
        assert each.design is not None
        settings = each.design.search.steps, each.design.search.tolerance, str(each.design.formats.rounding)
        assert settings == tuple(each.facts[name] for name in ("steps", "plateau_tolerance_lsb", "rounding"))
        assert replace(each.design, search=BASE.search, formats=BASE.formats) == BASE
        assert each.compared == ((Step.ARITHMETIC,) if each.facts["variant"] == "rounding" else tuple(Step))


def test_costs_by_hand() -> None:
    """A core of 8 lanes with 18-bit words: one each, four of combine, three of scalars, scaling's."""
    design = replace(BASE, architecture=Architecture(8))
    word = max(design.widths.force, design.widths.division)
    assert products(design)[:12] == [(18, 18)] * 12
    assert dsp(design, DEFAULT) == 8 + 4 + 3 + -(-(word - 1) // 17)
    assert coefficient_kbit(design) == design.coefficient_bits / 1000
    assert multiplier_kbit(design) == design.multiplications * 18 * 18 / 1000


def test_products_of_a_short_layer_cost_less() -> None:
    design = learned_design()
    shorter = Space.design(design, {"coefficient.first": 10, "operand.second": 12})
    first, second = (sum(op.rows.size for op in design.stacks[name].operators) for name in ("first", "second"))
    of_first = design.stacks["first"].operators[0].rows.size
    saved = of_first * 8 * 18 + second * 18 * 6
    assert first > of_first
    assert multiplier_kbit(design) - multiplier_kbit(shorter) == pytest.approx(saved / 1000)


def test_an_estimator_that_sweeps_nothing_has_no_variants_of_a_sweep() -> None:
    found = variants(learned_design(), (10, 500), (0.0, 0.3))
    assert [each.facts["variant"] for each in found] == ["rounding"] * len(Rounding)
    signals = {each.facts["signal"] for each in sensitivity(learned_design(taxel_forces=False), DEFAULT, (1,))}
    assert signals.isdisjoint({"coefficient.inverse", "operand.field", "operand.combine", "sums", "direction"})
    assert signals >= {"coefficient.first", "operand.second", "scalar", "vector_fraction"}


@pytest.mark.long
@pytest.mark.parametrize(
    ("design", "target"),
    [
        (replace(BASE, architecture=Architecture(8), target="ecp5"), "ecp5-45"),
        (TfraDesign(BASE.sensor, formats=replace(BASE.formats, coefficient=24, operand=22), target="ecp5"), "ecp5-45"),
        (TfraDesign(BASE.sensor, formats=replace(BASE.formats, coefficient=20, operand=20), target="ecp5"), "ecp5-45"),
        (TfraDesign(BASE.sensor, formats=replace(BASE.formats, coefficient=20, operand=20)), "ecp5-45"),
        (TfraDesign(BASE.sensor, architecture=SERIAL, target="ice40"), "ice40up5k"),
        (learned_design(target="ecp5"), "ecp5-45"),
        (learned_design(taxel_forces=False), "ecp5-45"),
        (learned_design(architecture=SERIAL, target="ice40"), "ice40up5k"),
    ],
)
def test_multipliers_are_those_of_the_estimate(design: Design, target: str) -> None:
    family = find(target).family
    assert dsp(design, family) == estimate(design, family).total["DSP"]
