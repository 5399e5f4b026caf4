"""Tables of variations against direct calls of the model and NumPy, however the work is split."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from tests.study.definitions import LAYER, MIXTURE, SENSOR, complete, definition, design, section, tables_of
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.rounding import Rounding
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra
from tfra.study.errors.cascade import SIGNED, Cascade, Step, View
from tfra.study.errors.statistics import errors, flagged, flips
from tfra.study.errors.variation import Variation, cascade_of
from tfra.study.frames.block import BLOCK, Part
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.tasks import Comparison, Job

EVEN = MIXTURE.replace("force_n = -2", "force_n = -2\nnoise_share_of_peak = 0.001")
"""All frames have noise of the same share."""


def changed(**formats: Any) -> TfraDesign:
    base = design()
    return replace(base, formats=replace(base.formats, name="custom", **formats))


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> FrameSet:
    return complete(tmp_path_factory.mktemp("frames"), definition(EVEN, train=BLOCK + 60))


def some() -> tuple[Variation, ...]:
    """Variations that have little in common."""
    return (
        Variation.of({"name": "base"}, design, compared=tuple(Step)),
        Variation.of({"name": "coarse"}, lambda: changed(coefficient=10)),
        Variation.of({"name": "none"}, lambda: changed(coefficient=5)),
        Variation.of({"name": "noise"}, design, noise=0.01, compared=(Step.NOISE, Step.CONVERTER)),
        Variation.of({"name": "cut"}, lambda: changed(rounding=Rounding.TRUNCATE)),
    )


def measured(frames: FrameSet, variations: tuple[Variation, ...], **how: Any) -> pl.DataFrame:
    return tables_of(Comparison("measured", frames, variations, **how))["measured"]


@pytest.fixture(scope="module")
def table(frames: FrameSet) -> pl.DataFrame:
    return measured(frames, some())


@pytest.mark.parametrize("each", [each for each in some() if each.design], ids=lambda each: each.facts["name"])
def test_errors_are_those_of_the_cascade_on_all_frames(frames, table, each):
    cascades = [cascade_of(frames, Part.TRAIN, number) for number in (0, 1)]
    scores = pl.concat([cascade(each.design, noise=each.noise) for cascade in cascades])
    expected = errors(scores, each.compared)
    found = table.filter(name=each.facts["name"])
    assert found.select(expected.columns).equals(expected)
    rate = flips(scores).filter(step=Step.ARITHMETIC, decision="sweep_index_equal")["rate"].item()
    assert set(found["sweep_index_equal"]) == {rate}
    assert set(found["left_out"]) == {flagged(scores)["frames"][-1]}
    assert set(found["frames"]) == {BLOCK + 60}


def test_what_does_not_fit_is_there_with_its_reason(table):
    found = table.filter(name="none")
    assert found.select("quantity", "step", "view").rows() == [(q, "arithmetic", v) for q in SIGNED for v in View]
    assert set(found["reason"]) == {"coefficient: 6 to 27 bits are supported, got 5"}
    numbers = found.drop("name", "quantity", "step", "view", "reason")
    assert numbers.null_count().row(0) == (len(found),) * numbers.width
    assert table.filter(pl.col("name") != "none")["reason"].null_count() == len(table) - len(found)


def test_words_that_could_overflow_do_not_fit():
    """Taxels at a third of the cover's thickness: operators so badly conditioned that sums need more than 63 bits."""
    found = Variation.of({}, lambda: TfraDesign(SensorArray(10, 10, 1e-3, 1e-3, 3e-3)))
    assert found.design is None
    assert "can overflow" in str(found.reason)


def test_types_of_columns_do_not_hang_on_values(frames, table):
    alone = measured(frames, some()[2:3])
    assert {name: alone.schema[name] for name in alone.columns} == {name: table.schema[name] for name in alone.columns}


@pytest.mark.long
def test_any_split_gives_the_same(frames, table):
    assert measured(frames, some(), together=3).equals(table)


def test_jobs_cover_everything_once(frames):
    jobs = Comparison("measured", frames, some(), together=3).jobs
    assert jobs == [Job(0, 0, 3), Job(0, 3, 5), Job(1, 0, 3), Job(1, 3, 5)]


def test_float_is_asked_once_for_what_variations_share(frames, monkeypatch):
    asked: list[object] = []
    original = Tfra.__call__

    def counted(self, frames, **options):
        asked.append(frames)
        return original(self, frames, **options)

    monkeypatch.setattr(Tfra, "__call__", counted)
    variations = tuple(
        Variation.of({"bits": bits}, lambda bits=bits: changed(coefficient=bits)) for bits in (12, 14, 16)
    )
    Comparison("measured", frames, variations)(Job(1, 0, 3))
    assert len(asked) == 3


def test_noise_takes_the_place_of_the_frames_own(frames):
    cascade = cascade_of(frames, Part.TRAIN, 1)
    own, same, none, double = (cascade(design(), noise=level) for level in (None, 0.001, 0.0, 0.002))
    assert same.equals(own)
    assert not double.equals(own)
    block = frames.block(Part.TRAIN, 1)
    offset = np.abs(block.stress).max(axis=(1, 2)) * block.truth["offset_share_of_peak"].to_numpy()
    noisy = (block.stress + offset[:, None, None]).astype(np.float32)
    assert none.equals(Cascade(replace(block, noisy=noisy))(design()))


def test_noise_on_a_recording(tmp_path: Path):
    recorded = definition().make(Part.TRAIN, 0).stress
    np.savez(tmp_path / "frames.npz", frames=recorded)
    wanted = section("", train=30, held_out=10, seed=3, recording="frames.npz")
    frames = complete(tmp_path / "set", Definition.of(tmp_path / "study.toml", SENSOR, LAYER, wanted))
    variations = tuple(Variation.of({"noise": x}, design, noise=x, compared=(Step.NOISE,)) for x in (0.0, 0.01))
    found = measured(frames, variations, part=Part.HELD_OUT)
    worst = found.filter(quantity="force_z_n", view="own")["worst"]
    assert worst[0] == 0
    assert worst[1] > 0
    assert math.isnan(frames.block(Part.HELD_OUT, 0).mu[0])
    assert set(found.filter(quantity="mu", view="total")["count"]) == {0}
