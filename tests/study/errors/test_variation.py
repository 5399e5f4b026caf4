"""Tables of variations against direct calls of the model and NumPy, however the work is split."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from tests.study.definitions import LAYER, MIXTURE, SENSOR, definition, design, section, tables_of
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.words import decode
from tfra.model.rounding import Rounding
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status, Tfra
from tfra.study.errors.cascade import SIGNED, Cascade, Step, View
from tfra.study.errors.statistics import errors, flips
from tfra.study.errors.variation import Variation, cascade_of
from tfra.study.frames.block import BLOCK, Part
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.tasks import Comparison, Job

EVEN = MIXTURE.replace("force_n = -2", "force_n = -2\nnoise_share_of_peak = 0.001")
"""All frames have noise of the same share."""


def shorter(bits: int) -> TfraDesign:
    base = design()
    return replace(base, formats=replace(base.formats, name="custom", coefficient=bits))


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> FrameSet:
    found = FrameSet.create(tmp_path_factory.mktemp("frames"), definition(EVEN, train=BLOCK + 60))
    found.complete()
    return found


def truncated() -> TfraDesign:
    base = design()
    return replace(base, formats=replace(base.formats, rounding=Rounding.TRUNCATE))


def some() -> tuple[Variation, ...]:
    """Variations that have little in common."""
    return (
        Variation.of({"name": "base"}, design, compared=tuple(Step)),
        Variation.of({"name": "coarse"}, lambda: shorter(10)),
        Variation.of({"name": "none"}, lambda: shorter(5)),
        Variation.of({"name": "noise"}, design, noise=0.01, compared=(Step.NOISE, Step.CONVERTER)),
        Variation.of({"name": "cut"}, truncated),
    )


def measured(frames: FrameSet, variations: tuple[Variation, ...], **how: Any) -> pl.DataFrame:
    return tables_of(Comparison("measured", frames, variations, **how))["measured"]


@pytest.fixture(scope="module")
def table(frames: FrameSet) -> pl.DataFrame:
    return measured(frames, some())


def test_the_base_is_the_cascade(frames, table):
    blocks = pl.concat([Cascade(SENSOR, block)(design()) for block in frames.blocks(Part.TRAIN)])
    expected = errors(blocks)
    found = table.filter(name="base")
    assert found.select(expected.columns).equals(expected)
    rate = flips(blocks).filter(step=Step.ARITHMETIC, decision="sweep_index_equal")["rate"].item()
    assert set(found["sweep_index_equal"]) == {rate}
    assert set(found["frames"]) == {BLOCK + 60}


def test_a_shorter_word_against_direct_calls(frames, table):
    core, lsb = shorter(10), 400e3 / 2**11
    noisy = np.concatenate([block.noisy for block in frames.blocks(Part.TRAIN)]).astype(np.float64)
    exact = np.concatenate([block.stress for block in frames.blocks(Part.TRAIN)])
    true = np.concatenate([block.resultant for block in frames.blocks(Part.TRAIN)])
    codes = np.clip(np.rint(noisy / lsb), -2048, 2047).astype(np.int64)
    tfra = Tfra(SENSOR, 100, contact_threshold=core.adc.threshold * lsb)
    by_float, by_words = tfra(codes * lsb), decode(core, core.model(codes).words)
    flags = tfra(exact).status | tfra(noisy).status | by_float.status | (by_words.status & ~Status.OUTPUT_SATURATED)
    keep = flags & ~Status.INPUT_SATURATED == 0
    modulus = np.linalg.norm(true, axis=1)
    expected = {
        ("mu", "own"): (by_words.mu - by_float.mu)[keep],
        ("force_z_n", "total"): (by_words.resultant - true)[keep, 2],
        ("force_difference_percent_of_true_force", "own"): (
            100 * np.linalg.norm(by_words.resultant - by_float.resultant, axis=1) / modulus
        )[keep],
    }
    for (quantity, view), values in expected.items():
        (row,) = table.filter(name="coarse", quantity=quantity, view=view).rows(named=True)
        assert (row["step"], row["count"]) == ("arithmetic", keep.sum())
        assert row["left_out"] == (~keep).sum()
        assert row["median"] == pytest.approx(np.median(np.abs(values)), rel=1e-6)
        assert row["p95"] == pytest.approx(np.quantile(np.abs(values), 0.95), rel=1e-6)
        assert row["worst"] == pytest.approx(np.abs(values).max(), rel=1e-6)
        if SIGNED[quantity]:
            assert row["bias"] == pytest.approx(values.mean(), rel=1e-4)


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
    variations = tuple(Variation.of({"bits": bits}, lambda bits=bits: shorter(bits)) for bits in (12, 14, 16))
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
    assert none.equals(Cascade(SENSOR, replace(block, noisy=noisy))(design()))


def test_noise_on_a_recording(tmp_path: Path):
    recorded = definition().make(Part.TRAIN, 0).stress
    np.savez(tmp_path / "frames.npz", frames=recorded)
    wanted = section("", train=30, held_out=10, seed=3, recording="frames.npz")
    frames = FrameSet.create(tmp_path / "set", Definition.of(tmp_path / "study.toml", SENSOR, LAYER, wanted))
    frames.complete()
    variations = tuple(Variation.of({"noise": x}, design, noise=x, compared=(Step.NOISE,)) for x in (0.0, 0.01))
    found = measured(frames, variations, part=Part.HELD_OUT)
    worst = found.filter(quantity="force_z_n", view="own")["worst"]
    assert worst[0] == 0
    assert worst[1] > 0
    assert math.isnan(frames.block(Part.HELD_OUT, 0).mu[0])
    assert set(found.filter(quantity="mu", view="total")["count"]) == {0}
