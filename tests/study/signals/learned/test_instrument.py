"""Signals of the learned estimator: observed words are the model's, float64 is the estimator taken apart."""

import numpy as np
import polars as pl
import pytest

from tests.model.fixed.learned.cases import learned_design
from tfra.model.arrays import Ints
from tfra.model.choices import FORMATS
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.learned import pipeline
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.pipeline import Stage
from tfra.model.tfra import Status
from tfra.study.signals.instruments import instrument
from tfra.study.signals.measures import Measures, length_table, range_table, stage_table, total

DESIGNS = {
    "6×8": learned_design(6, 8),
    "5×7, without forces": learned_design(5, 7, taxel_forces=False),
    "wide": learned_design(5, 6, formats=FORMATS["wide"]),
}


def scenes(design: LearnedDesign, count: int = 60) -> Ints:
    return np.concatenate(
        [contact_codes(design, count, seed=1), wild_codes(design, count, seed=2), directed_codes(design)]
    )


def measures(design: LearnedDesign, codes: Ints) -> Measures:
    return total([instrument(design).measure(codes)])


@pytest.mark.parametrize("name", DESIGNS)
def test_observed_words_are_the_models(name: str) -> None:
    design, inside = DESIGNS[name], instrument(DESIGNS[name])
    (trace,) = design.model.traces(scenes(design, 40))
    seen, words = inside.observe(trace), inside.words(trace)
    assert seen.keys() == inside.catalogue.keys()
    for signal in words.keys() & seen.keys():
        np.testing.assert_array_equal(seen[signal].values, words[signal], signal)
    assert words.keys() - seen.keys() == set()
    assert [str(stage) for stage in Stage if stage in {word.stage for word in inside.catalogue.values()}] == list(
        dict.fromkeys(word.stage for word in inside.catalogue.values())
    )


@pytest.mark.parametrize("name", DESIGNS)
def test_nothing_leaves_its_word_or_its_bound(name: str) -> None:
    design = DESIGNS[name]
    table = range_table(instrument(design).catalogue, measures(design, scenes(design)))
    assert not len(table.filter((pl.col("headroom_bits") < 0) | (pl.col("proven") & (pl.col("share") > 1))))
    assert (table.filter(pl.col("signal").str.ends_with(".operand"))["headroom_bits"] == 0).all()


@pytest.mark.parametrize("name", DESIGNS)
def test_the_reference_is_the_float_estimator(name: str) -> None:
    design, inside = DESIGNS[name], instrument(DESIGNS[name])
    codes = contact_codes(design, 40, seed=3)
    (trace,) = design.model.traces(codes)
    values, _ = inside.references(trace, {"codes": trace.codes} | inside.words(trace))
    exact = design.float_model(codes * design.adc.lsb)
    newton = design.adc.lsb * design.sensor.taxel_area * 2.0**-trace.frame.exponent
    size = np.abs(exact.resultant).max()
    np.testing.assert_allclose(values["resultant"] * newton[:, None], exact.resultant, atol=1e-9 * size)
    np.testing.assert_allclose(values["uncertainty"] * newton, exact.uncertainty, atol=1e-9 * size)
    np.testing.assert_allclose(values["mu"], exact.mu, rtol=1e-9)
    if design.taxel_forces:
        forces = values["forces"] * newton[:, None, None]
        np.testing.assert_allclose(forces, exact.forces.reshape(forces.shape), atol=1e-9 * size)


def test_longer_words_have_smaller_errors_and_activations_none() -> None:
    tables = []
    for formats in ("standard", "wide"):
        design = learned_design(5, 6, formats=FORMATS[formats])
        inside = instrument(design)
        tables.append(stage_table(inside.stage_of, measures(design, contact_codes(design, 60, seed=4))))
        alone = tables[-1].filter(reference="inputs")
        assert set(alone.filter("exact")["signal"]) == {"stress", "h1", "h2", "p0"}
    short, long = (
        dict(table.filter(reference="codes", exact=False).select("signal", "sqnr_db").iter_rows()) for table in tables
    )
    assert all(long[signal] > short[signal] + 20 for signal in short)


def test_an_error_is_found_in_its_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    """Units of the first layer that are a little too large are wrong by themselves, what follows only as a whole."""
    design = DESIGNS["6×8"]
    codes, inside = contact_codes(design, 40, seed=5), instrument(design)

    def errors() -> dict[tuple[str, str], float]:
        table = stage_table(inside.stage_of, measures(design, codes))
        return {(signal, of): rms for signal, of, rms in table.select("signal", "reference", "rms_error_lsb").rows()}

    before, original = errors(), pipeline.activation
    monkeypatch.setattr(pipeline, "activation", lambda quads: original(quads) + 50_000)
    after = errors()
    assert before["h1", "inputs"] == 0
    assert after["h1", "inputs"] == pytest.approx(50_000)
    assert after["second", "codes"] > 10 * before["second", "codes"]
    assert after["second", "inputs"] < 2 * before["second", "inputs"]


def test_decisions_are_compared_with_float(monkeypatch: pytest.MonkeyPatch) -> None:
    design = DESIGNS["6×8"]
    codes = scenes(design)
    flips = measures(design, codes)["flips"]
    assert list(flips) == ["contact", "no direction", "implausible"]
    exact = design.float_model(codes * design.adc.lsb).status
    assert flips["contact"] == {"frames": len(codes), "flips": 0}
    assert flips["implausible"]["frames"] == (exact & Status.NO_CONTACT == 0).sum()
    assert flips["implausible"]["flips"] <= 1
    original = pipeline.judged
    monkeypatch.setattr(pipeline, "judged", lambda design, outputs, threshold: original(design, outputs, 0))
    assert measures(design, codes)["flips"]["implausible"]["flips"] > flips["implausible"]["flips"] + 2


def test_lengths_are_those_of_literal_words() -> None:
    design = DESIGNS["6×8"]
    codes = np.zeros((1, 6, 8), dtype=np.int64)
    codes[0, 0, :3] = -2048, 3, 1  # of 11, 2 and 1 bits beside the sign
    table = length_table(design, measures(design, codes))
    assert dict(table.filter(kind="signal", name="stress").select("significant_bits", "share").iter_rows()) == (
        pytest.approx({0: 45 / 48, 1: 1 / 48, 2: 1 / 48, 11: 1 / 48})
    )
    shares = table.group_by("kind", "name").agg(pl.sum("share"))
    np.testing.assert_allclose(shares["share"], 1)
    read2 = np.abs(design.stacks["read"].operators[0].rows)
    of_read2 = table.filter(kind="coefficient", name="read2")
    assert of_read2["significant_bits"].max() == int(read2.max()).bit_length() == 17
    assert of_read2.filter(significant_bits=0)["share"].item() == pytest.approx((read2 == 0).mean())
