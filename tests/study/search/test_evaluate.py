"""Errors and costs of a point: those that are found directly, in the order of what they cost."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.study.definitions import complete, definition, design
from tfra.families import find
from tfra.hdl.cores import microarchitecture
from tfra.model.converter import convert
from tfra.model.fixed.words import decode
from tfra.model.tfra import Tfra
from tfra.study.errors.cascade import Cascade
from tfra.study.errors.statistics import unflagged
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.search import evaluate
from tfra.study.search.costs import COSTS, CYCLES
from tfra.study.search.evaluate import CHANGE, Evaluation, TooFewError, percentile
from tfra.study.search.space import Space
from tfra.study.search.trials import COMPLETE, STOPPED, UNFIT

BASE = design()
FORCE, FIELD = "force_difference_percent_of_true_force", "taxel_forces_percent_of_true_taxel_forces"


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> FrameSet:
    return complete(tmp_path_factory.mktemp("frames"), definition(train=1500, held_out=600))


def evaluation(frames: FrameSet, *costs: str, **more: Any) -> Evaluation:
    return Evaluation(BASE, frames, costs, find("ecp5-45"), **{"quantities": (FORCE, FIELD)} | more)


def test_errors_are_those_of_the_frames_that_count(frames: FrameSet) -> None:
    """Directly: model and float TFRA on the codes of all blocks, frames that the cascade keeps."""
    point = {"coefficient": 6, "mac_lanes": 4}
    core, errors, exact = Space.design(BASE, point), [], []
    for block in frames.blocks(Part.TRAIN):
        codes, counts = convert(core, block.noisy), unflagged(Cascade(block)(BASE)).to_numpy()
        results = decode(core, core.model(codes).words), Tfra.of(core)(codes * core.adc.lsb)
        for found, into in zip(results, (errors, exact), strict=True):
            difference = np.linalg.norm(found.resultant - block.resultant, axis=1)
            into.append((100 * difference / np.linalg.norm(block.resultant, axis=1))[counts])
    assert len(errors) == 2
    measured = evaluation(frames, "coefficient_kbit", quantities=(FORCE,))(point)
    assert measured.state == COMPLETE
    p95, floor = (np.percentile(np.concatenate(values), 95) for values in (errors, exact))
    assert measured.values[FORCE] == pytest.approx(p95, rel=1e-12)
    assert measured.values[CHANGE] == pytest.approx(100 * (p95 / floor - 1), rel=1e-9)
    assert measured.values["coefficient_kbit"] == core.coefficient_bits / 1000
    assert evaluation(frames, quantities=(FORCE,)).exact() == {FORCE: pytest.approx(floor, rel=1e-12)}


def test_the_worst_quantity_counts(frames: FrameSet) -> None:
    point = {"coefficient": 6, "mac_lanes": 4}
    alone = [evaluation(frames, quantities=(name,))(point).values[CHANGE] for name in (FORCE, FIELD)]
    assert evaluation(frames)(point).values[CHANGE] == max(alone)


@pytest.mark.parametrize("names", [("coefficient_kbit", *CYCLES), pytest.param(COSTS, marks=pytest.mark.long)])
def test_costs_are_those_of_the_core(frames: FrameSet, names: tuple[str, ...]) -> None:
    core = Space.design(BASE, {"coefficient": 8, "mac_lanes": 8})
    found, timed = evaluation(frames, *names).cost_values(core), microarchitecture(core)
    assert (found["latency_cycles"], found["interval_cycles"]) == (timed.latency, timed.initiation_interval)
    assert found.get("DSP", 8) >= 8
    assert list(found) == list(names)


def test_what_does_not_fit_says_why(frames: FrameSet) -> None:
    measured = evaluation(frames)({"coefficient": 8, "mac_lanes": 7})
    assert (measured.state, measured.values) == (UNFIT, {})
    assert measured.reason.startswith("architecture.mac_lanes: ")


def test_the_first_block_is_enough_to_give_up(frames: FrameSet, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    errors = Evaluation.errors

    def watched(self: Evaluation, design: Any, count: int) -> dict[str, float]:
        asked.append(count)
        return errors(self, design, count)

    monkeypatch.setattr(Evaluation, "errors", watched)
    point = {"coefficient": 6, "mac_lanes": 4}
    assert evaluation(frames)(point).state == COMPLETE
    assert asked == [1, 2]
    asked.clear()
    measured = evaluation(frames, "coefficient_kbit", limit=-20.0)(point)
    assert measured.state == STOPPED
    assert asked == [1]
    assert set(measured.values) == {CHANGE, FORCE, FIELD}
    assert measured.reason.endswith(" on 1 of 2 blocks is over -5")


def test_a_limit_holds_for_all_frames(frames: FrameSet) -> None:
    """A design just over it is looked at to the end."""
    point = {"coefficient": 6, "mac_lanes": 4}
    change = evaluation(frames)(point).values[CHANGE]
    assert evaluation(frames, limit=change)(point).state == COMPLETE
    measured = evaluation(frames, limit=change - 1e-6)(point)
    assert measured.state == STOPPED
    assert "on 2 of 2 blocks" in measured.reason


def test_it_travels_light_and_stays_the_same(frames: FrameSet) -> None:
    one = evaluation(frames)
    point = {"coefficient": 18, "mac_lanes": 4}
    first = one(point)
    packed = pickle.dumps(one)
    assert len(packed) < 10_000
    assert pickle.loads(packed)(point) == first


def test_held_out_frames_are_others(frames: FrameSet) -> None:
    point = {"coefficient": 18, "mac_lanes": 4}
    assert evaluation(frames)(point) != evaluation(frames, part=Part.HELD_OUT)(point)


def test_samples_are_those_of_the_frames_and_of_the_search(frames: FrameSet) -> None:
    """What a process keeps for its next design is not mistaken for that of another converter."""
    point = {"coefficient": 18, "mac_lanes": 4}
    coarse = replace(evaluation(frames), base=replace(BASE, adc=replace(BASE.adc, bits=8)))
    assert coarse(point) != evaluation(frames)(point)
    assert evaluate._sample.cache_info().currsize > 1


def test_few_frames_have_no_percentile() -> None:
    errors = np.arange(201.0)
    errors[0] = np.nan
    assert percentile(errors) == pytest.approx(np.percentile(errors[1:], 95))
    with pytest.raises(TooFewError, match=r"^frames: 199 frames that count are too few for a 95th percentile$"):
        percentile(errors[1:200])
