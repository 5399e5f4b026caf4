"""The steps of a skin are direct calls of its models, and contacts are matched as by trying everything."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import polars as pl
import pytest

from tests.study.skins.definitions import a_block
from tfra.families import DEFAULT
from tfra.model.converter import convert
from tfra.model.skin.records import decode_records, records
from tfra.model.skin.result import SkinResult, estimate
from tfra.model.skin.skin import Skin
from tfra.study.errors.cascade import Step
from tfra.study.errors.comparisons import converters, uniform
from tfra.study.frames.block import Block
from tfra.study.skins.cascade import SkinCascade
from tfra.study.skins.crowds import contacts_of

APART = 3.0


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Skin, Block]:
    loaded, block = a_block(tmp_path_factory.mktemp("skin"), 40)
    return loaded.skin, block


@pytest.fixture(scope="module")
def scores(case: tuple[Skin, Block]) -> pl.DataFrame:
    return cascade(*case)(case[0].window)


def cascade(skin: Skin, block: Block) -> SkinCascade:
    return SkinCascade(skin, block, lambda: np.random.default_rng(1).standard_normal(block.stress.shape))


def direct(skin: Skin, block: Block) -> dict[Step, SkinResult]:
    """The steps as others call them."""
    codes, in_float = convert(skin, block.noisy), skin.window.float_model
    return {
        Step.METHOD: estimate(skin, block.stress, in_float),
        Step.NOISE: estimate(skin, block.noisy, in_float),
        Step.CONVERTER: estimate(skin, codes * skin.adc.lsb, in_float),
        Step.ARITHMETIC: decode_records(skin, records(skin, codes, skin.window.model.words)),
    }


def tried(true: np.ndarray, seen: np.ndarray) -> dict[int, int]:
    """The pairs of places: as many as possible, then the nearest, by trying all."""
    best: tuple[int, float, dict[int, int]] = (0, 0.0, {})
    choices = [*range(len(seen)), *[-1] * len(true)]
    for order in set(permutations(choices, len(true))):
        pairs = {k: at for k, at in enumerate(order) if at >= 0}
        far = [np.square(true[k] - seen[at]).sum() for k, at in pairs.items()]
        if all(each < APART**2 for each in far) and (len(pairs), -sum(far)) > (best[0], best[1]):
            best = (len(pairs), -sum(far), pairs)
    return best[2]


def test_errors_are_those_of_the_contacts_that_belong_together(case: tuple[Skin, Block], scores: pl.DataFrame) -> None:
    skin, block = case
    table, frame = contacts_of(block)
    force = table.select("force_x_n", "force_y_n", "force_z_n").to_numpy()
    center = table.select("center_x_m", "center_y_m").to_numpy()
    pitch = np.array([3e-3, 2.5e-3])
    expected = (center - 0.8 * 2e-3 * force[:, :2] / force[:, 2:]) / pitch
    at, results = {}, direct(skin, block)
    for step, result in results.items():
        places = np.stack([result.x, result.y], axis=1) / pitch
        at[step] = np.full(len(frame), -1)
        for number in range(len(block)):
            true, seen = np.flatnonzero(frame == number), np.flatnonzero(result.frame == number)
            for k, found in tried(expected[true], places[seen]).items():
                at[step][true[k]] = seen[found]
        assert (scores[f"missed.{step}"].to_numpy() == (at[step] < 0)).all()
        assert scores[f"seen.{step}"].sum() == len(result.frame)
        assert scores[f"invented.{step}"].sum() == len(result.frame) - (at[step] >= 0).sum()
    everywhere = np.min([at[step] for step in Step], axis=0) >= 0
    assert 0 < (~everywhere).sum() < len(everywhere) / 2
    truth = force[everywhere], table["mu"].to_numpy()[everywhere], center[everywhere] / pitch
    before = truth
    for step, result in results.items():
        which = at[step][everywhere]
        windows, place = result.windows, np.stack([result.x, result.y], axis=1)[which] / pitch
        length = np.linalg.norm(force[everywhere], axis=1)
        of_step = windows.resultant[which], windows.mu[which], place
        for view, (f, mu, where) in (("total", truth), ("own", before)):
            wanted = {
                "force_difference_percent_of_true_force": 100 * np.linalg.norm(of_step[0] - f, axis=1) / length,
                "mu": of_step[1] - mu,
                "place_pitches": np.linalg.norm(place - where, axis=1),
            }
            for key, values in wanted.items():
                given = scores[f"{key}.{step}.{view}"].to_numpy()
                np.testing.assert_allclose(given[everywhere], values, rtol=1e-4, atol=1e-5)
                assert np.isnan(given[~everywhere]).all()
        turned = (windows.phi_deg[which] - table["phi_deg"].to_numpy()[everywhere] + 180) % 360 - 180
        np.testing.assert_allclose(scores[f"phi_deg.{step}.total"].to_numpy()[everywhere], turned, rtol=1e-4, atol=1e-3)
        before = of_step


def test_arithmetic_finds_what_the_converter_does(scores: pl.DataFrame) -> None:
    for name in ("missed", "merged", "seen", "invented"):
        assert scores[f"{name}.converter"].equals(scores[f"{name}.arithmetic"], check_names=False)
    assert scores["place_pitches.arithmetic.own"].max() == 0
    assert scores["mu.arithmetic.own"].abs().max() > 0


def test_merged_contacts_are_taken_by_others_and_faint_ones_are_not(case: tuple[Skin, Block]) -> None:
    skin, _ = case
    row, column = np.indices((14, 16))
    stress = np.zeros((1, 14, 16), dtype=np.float32)
    for y, x, height in ((4, 4, 1e5), (4, 6, 8e4), (11, 13, 1e3)):  # the second is at the slope, the third too faint
        stress[0] -= height * np.exp(-((row - y) ** 2 + (column - x) ** 2) / 2)
    lists = {
        "center_x_m": np.array([4, 6, 13]) * 3e-3,
        "center_y_m": np.array([4, 4, 11]) * 2.5e-3,
        "gap_pitches": np.array([0.0, 0.0, 5.0]),
        **{key: np.zeros(3) for key in ("force_x_n", "force_y_n", "mu", "phi_deg")},
        "force_z_n": -np.ones(3),
    }
    truth = pl.DataFrame({key: [values.tolist()] for key, values in lists.items()})
    made = Block(0, stress, stress, np.full_like(stress, np.nan), truth)
    found = cascade(skin, made)(skin.window)
    assert found["missed.method"].to_list() == [False, True, True]
    assert found["merged.method"].to_list() == [False, True, False]
    assert found["seen.method"].to_list() == [1, 0, 0]
    assert found["invented.arithmetic"].to_list() == [0, 0, 0]


def test_variations_are_designs_of_their_own(case: tuple[Skin, Block], scores: pl.DataFrame) -> None:
    skin, block = case
    steps = cascade(skin, block)
    for each in uniform(skin.window, [6, 18], DEFAULT):
        assert each.design is not None
        words = replace(skin, window=each.design)
        result = decode_records(words, records(words, convert(skin, block.noisy), each.design.model.words))
        given = steps(each.design, each.compared)
        assert set(given.columns) < set(scores.columns)
        assert given["seen.arithmetic"].sum() == len(result.frame)
        assert each.facts["coefficient_kbit"] == each.design.coefficient_bits / 1000
    own = "mu.arithmetic.own"
    few, many = (
        steps(each.design)[own].abs().median() for each in uniform(skin.window, [6, 18], DEFAULT) if each.design
    )
    assert few > 5 * many
    quiet, noisy = converters(skin.window, [10], [0.0, 0.05])
    assert quiet.design == noisy.design
    assert quiet.design is not None
    assert quiet.design.adc.lsb == 4 * skin.adc.lsb
    without = steps(quiet.design, quiet.compared, quiet.noise)
    offset = block.truth["offset_share_of_peak"][0]
    peak = np.abs(block.stress.astype(np.float64)).max(axis=(1, 2), keepdims=True)
    same = cascade(skin, replace(block, noisy=(block.stress + peak * offset).astype(np.float32)))(quiet.design)
    assert without.equals(same.select(without.columns))
    assert steps(quiet.design, noisy.compared, noisy.noise)["missed.noise"].sum() >= without["missed.noise"].sum()
