"""Studies of the learned estimator, and of both estimators on the same frames."""

import pickle
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from tests.model.fixed.learned.cases import learned_design
from tests.study.definitions import complete, definition, design, tables_of
from tfra.families import find
from tfra.model.converter import convert
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.words import decode
from tfra.study.errors.cascade import Cascade, Step, View, decision_column, error_column
from tfra.study.errors.statistics import flips, index_equal_rate, unflagged
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.search.evaluate import CHANGE, Evaluation
from tfra.study.search.trials import COMPLETE
from tfra.study.tasks import Errors, Estimators, Signals

TFRA = design()
FORCE = "force_difference_percent_of_true_force"


def learned(seed: int = 0) -> LearnedDesign:
    """For the sensor and the converter of the studies' tests."""
    return replace(learned_design(6, 8, seed=seed), sensor=TFRA.sensor, adc=TFRA.adc, threshold=100.0)


BASE = learned()


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> FrameSet:
    return complete(tmp_path_factory.mktemp("frames"), definition(train=400, held_out=300))


def test_steps_are_those_of_the_network(frames: FrameSet) -> None:
    """Directly: float on exact stress, with noise and on codes, and the bit-accurate model."""
    block = frames.block(Part.TRAIN, 0)
    scores, codes = Cascade(block)(BASE), convert(BASE, block.noisy)
    in_float = BASE.float_model
    results = {
        Step.METHOD: in_float(block.stress),
        Step.NOISE: in_float(block.noisy),
        Step.CONVERTER: in_float(codes * BASE.adc.lsb),
        Step.ARITHMETIC: decode(BASE, BASE.model(codes).words),
    }
    modulus = np.linalg.norm(block.resultant, axis=1)
    for step, result in results.items():
        expected = 100 * np.linalg.norm(result.resultant - block.resultant, axis=1) / modulus
        found = scores[error_column(FORCE, step, View.TOTAL)].to_numpy()
        np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert decision_column("quadrant", Step.NOISE) in scores.columns
    assert decision_column("sweep_index", Step.NOISE) not in scores.columns
    assert set(flips(scores)["decision"]) == {"status", "quadrant"}
    assert index_equal_rate(scores) is None


def test_weights_are_the_same_by_their_numbers() -> None:
    """Else samples would be made again for each design of a search, and pieces of other weights would be taken."""
    again, other = pickle.loads(pickle.dumps(BASE)), learned(seed=1)
    assert again == BASE
    assert hash(again.weights) == hash(BASE.weights)
    assert repr(again) == repr(BASE)
    nearly = replace(BASE.weights, read2=BASE.weights.read2 * (1 + 1e-12))
    assert repr(other) != repr(BASE)
    assert repr(nearly) != repr(BASE.weights)
    assert nearly != BASE.weights


def test_all_tables_of_it(frames: FrameSet) -> None:
    tables = tables_of(Errors(BASE, frames)) | tables_of(Signals(BASE, frames))
    errors = tables["errors"].filter(quantity=FORCE, part="train", view="own").select("step", "median")
    medians = dict(errors.iter_rows())
    assert medians["arithmetic"] < 0.1 * medians["converter"] < medians["method"]
    assert {"first", "h1", "outputs", "forces"} <= set(tables["stages"]["signal"])
    assert {"first.operand", "h2", "share"} <= set(tables["ranges"]["signal"])
    assert set(tables["lengths"]["kind"]) == {"signal", "coefficient"}


def test_both_estimators_have_the_same_frames(frames: FrameSet) -> None:
    others = (("small", TFRA), ("network", BASE), ("other", learned(seed=1)))
    table = tables_of(Estimators(others, frames))["estimators"]
    counts = table.filter(quantity="mu")["count"]
    assert counts.n_unique() == 1
    block = frames.block(Part.HELD_OUT, 0)
    scores = {name: Cascade(block)(each) for name, each in others}
    keep = np.all([unflagged(each).to_numpy() for each in scores.values()], axis=0)
    assert counts[0] == keep.sum() < len(block)
    for name, each in others:
        row = table.row(
            by_predicate=(pl.col("design") == name)
            & (pl.col("quantity") == FORCE)
            & (pl.col("step") == "arithmetic")
            & (pl.col("view") == "total"),
            named=True,
        )
        values = scores[name][error_column(FORCE, Step.ARITHMETIC, View.TOTAL)].to_numpy()[keep]
        assert row["median"] == pytest.approx(np.median(values), rel=1e-6)
        assert row["estimator"] == each.estimator


def test_a_search_measures_it(frames: FrameSet) -> None:
    costs = ("multiplier_kbit", "coefficient_kbit", "DSP", "latency_cycles")
    measure = Evaluation(BASE, frames, costs, find("ecp5-45"), (FORCE,))
    shorter, whole = measure({"coefficient.first": 8, "operand.second": 10}), measure({"coefficient": 18})
    assert shorter.state == whole.state == COMPLETE
    assert shorter.values[CHANGE] > whole.values[CHANGE]
    assert shorter.values["multiplier_kbit"] < whole.values["multiplier_kbit"]
    assert shorter.values["latency_cycles"] == whole.values["latency_cycles"]
