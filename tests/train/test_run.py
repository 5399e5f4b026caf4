"""Trainings: seeds, continuation, early stop, divergence, the working folder, and the command."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.codegen.config.weights import Trained, read_weights
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import any_contacts
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.learned.network import Network
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import InputError
from tfra.runtime.store import work_folder
from tfra.train import heldout, loop, patches, pool, skins
from tfra.train import run as running
from tfra.train.heldout import held_out, threshold
from tfra.train.loop import State, Trainer
from tfra.train.rounding import Rounding
from tfra.train.run import Advance, Budget, fingerprint, run

SENSOR = SensorArray(4, 5, 2e-3, 2e-3, 2e-3)
BUDGET = Budget((6, 4), 3, steps=60)
CALIBRATION = f"""form = "tfra-calibration-1"
gain_error = {[[0.02] * 5] * 4}
dead = {{dead}}
[cover]
thickness_mm = {{thickness}}
thickness_error_mm = 0.02
poisson = 0.47
poisson_error = 0.01
"""
CONFIG = "[sensor]\nrows = 4\ncolumns = 5\npitch_x_mm = 2\npitch_y_mm = 2\nthickness_mm = 2\n"


class Cut(Exception):
    """An interruption."""


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    for module, name, value in (
        (pool, "CHUNK", 128), (loop, "CHUNKS", 4), (loop, "VALIDATION", 1), (loop, "CHECK", 20), (loop, "WARM", 10),
        (loop, "PATIENCE", 1.0), (running, "SAVE_EVERY", 0.0), (running, "TRIED", 20),
        (heldout, "held_out", partial(held_out, count=50)),
        (heldout, "threshold", partial(threshold, count=50)),
        (patches, "CHUNK", 64),
        (skins, "held_out", partial(skins.held_out, count=2)),
        (skins, "threshold", partial(skins.threshold, count=50)),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, value)


def trainer(seed: int = 3) -> Trainer:
    return Trainer(SENSOR, (6, 4), seed, lambda pieces: None)


def nothing(state: State) -> None: ...


@contextmanager
def silent(stage: str, pieces: int, there: int) -> Iterator[Advance]:
    yield lambda pieces, state=None: None


def cutting(after: int) -> running.Reporter:
    @contextmanager
    def reporter(stage: str, pieces: int, there: int) -> Iterator[Advance]:
        def advance(pieces: int, state: State | None = None) -> None:
            if state is not None and state.step == after:
                raise Cut

        yield advance

    return reporter


def same(left: Trained, right: Trained) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(astuple(left.weights), astuple(right.weights), strict=True))


def complaint(folder: Path, budget: Budget = BUDGET) -> str:
    with pytest.raises(InputError) as caught:
        run(SENSOR, budget, folder, silent)
    return str(caught.value).replace(f"{folder.parent}/", "")


def test_a_short_training_halves_the_loss() -> None:
    training = trainer()
    state = training.first()
    training.run(400, state, nothing)
    steps, losses, checks = zip(*state.curve, strict=True)
    assert steps == tuple(range(20, 401, 20))
    assert losses[-1] < losses[0] / 2
    assert checks[-1] < 0.5


def test_a_seed_makes_the_weights() -> None:
    found = []
    for seed in (3, 3, 4):
        state = trainer(seed).first()
        trainer(seed).run(30, state, nothing)
        found.append(state.vector)
    assert np.array_equal(found[0], found[1])
    assert not np.array_equal(found[0], found[2])


@pytest.mark.parametrize("after", [1, 33, 60])
def test_an_interrupted_training_continues_to_the_same_weights(tmp_path: Path, after: int) -> None:
    whole = run(SENSOR, BUDGET, tmp_path / "whole", silent)
    with pytest.raises(Cut):
        run(SENSOR, BUDGET, tmp_path / "cut", cutting(after))
    again = run(SENSOR, BUDGET, tmp_path / "cut", silent)
    assert same(whole, again)
    assert np.array_equal(whole.curve, again.curve)
    assert whole.held_out == again.held_out


def test_a_window_is_trained_among_others(tmp_path: Path) -> None:
    """An interrupted training of one continues, too, and is not that of an array."""
    budget = replace(BUDGET, window=True)
    whole = run(SENSOR, budget, tmp_path / "whole", silent)
    with pytest.raises(Cut):
        run(SENSOR, budget, tmp_path / "cut", cutting(33))
    assert same(whole, run(SENSOR, budget, tmp_path / "cut", silent))
    assert whole.window
    assert whole.prior["prior.crowded"] == patches.CROWDED
    assert "missed_at_0.001" in whole.held_out
    assert not same(whole, run(SENSOR, BUDGET, tmp_path / "array", silent))


def test_minutes_become_steps_once(tmp_path: Path) -> None:
    budget = Budget((6, 4), 3, minutes=0.005)
    with pytest.raises(Cut):
        run(SENSOR, budget, tmp_path / "w", cutting(2))
    begun = run(SENSOR, budget, tmp_path / "w", silent)
    steps = int(str(begun.prior["training.steps"]))
    assert steps >= 20
    assert same(begun, run(SENSOR, Budget((6, 4), 3, steps=steps), tmp_path / "w", silent))


def test_the_best_validation_counts_and_a_training_without_progress_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    training = trainer()
    state = training.first()
    monkeypatch.setattr(loop, "PATIENCE", 0.1)
    monkeypatch.setattr(loop, "RATE", 0.0)  # so that nothing changes
    training.run(1000, state, nothing)
    assert state.step == 20 + 100 + 1  # the first validation, and the patience is over
    assert np.array_equal(state.best, training.first().vector)


def test_a_damaged_state_is_refused(tmp_path: Path) -> None:
    run(SENSOR, BUDGET, tmp_path / "w", silent)
    (file,) = (tmp_path / "w").glob("*.state")
    data = bytearray(file.read_bytes())
    data[-40] ^= 1
    file.write_bytes(data)
    assert complaint(tmp_path / "w") == f"w/{file.name}: is not as it was written: remove it, to have it made again"
    file.unlink()
    run(SENSOR, BUDGET, tmp_path / "w", silent)


def test_a_folder_of_others(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes").write_text("mine")
    assert complaint(tmp_path / "mine") == "mine: is not the folder of a training: choose another one by --work"
    with work_folder(tmp_path / "w", "training", fingerprint()):
        held = "w: is in use by another run: wait for it, or choose another folder by --work"
        assert complaint(tmp_path / "w") == held
    about = tmp_path / "w" / "training.json"
    about.write_text(about.read_text().replace('"sources": "', '"sources": "0'))
    assert "with other sources, which is kept: choose another one by --work" in complaint(tmp_path / "w")


def test_held_out_errors_are_those_of_the_exact_series() -> None:
    """An estimate that knows the truth has no error, one that is off by a tenth has a tenth."""
    contacts = any_contacts(SENSOR, 50, np.random.default_rng(heldout.SEED))
    truth = contacts.force
    exact = frames(SENSOR, contacts).reshape(50, -1) * SENSOR.taxel_area

    def knows(n: np.ndarray) -> np.ndarray:
        assert np.abs(n - exact).max() <= 0.06 * np.abs(exact).max()
        return truth

    assert set(held_out(SENSOR, knows, 50).values()) == {0.0}
    found = held_out(SENSOR, lambda n: 1.1 * truth, 50)
    assert found["force_percent_95_at_0.01"] == pytest.approx(10.0)
    assert found["mu_50_at_0"] == pytest.approx(0.0, abs=1e-12)
    pushed = held_out(SENSOR, lambda n: truth * [1, 1, 0.5], 50)
    assert pushed["mu_50_at_0"] == pytest.approx(float(np.median(np.hypot(*truth.T[:2]) / -truth[:, 2])))


@pytest.fixture
def config(tmp_path: Path) -> Path:
    file = tmp_path / "sensor.toml"
    file.write_text(CONFIG)
    return file


def test_the_command(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = config.parent / "weights.npz"
    words = ["train", str(config), "--out", str(out), "--steps", "40", "--channels", "6", "4", "--seed", "3"]
    assert main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("held-out errors at 0.1 % noise, median / 95 %: mu ")
    assert lines[-1] == f"{out}: 6/4 units, 40 steps"
    trained = read_weights(out, SENSOR)
    assert trained.weights.counts == (6, 4)
    assert trained.curve[:, 0].tolist() == [20.0, 40.0]
    assert (trained.prior["training.seed"], trained.prior["training.steps"]) == (3, 40)
    before = out.read_bytes()
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["held_out"] == trained.held_out
    assert out.read_bytes() == before


def test_a_window_has_weights_of_its_own(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    array, skin, out = config, config.parent / "skin.toml", config.parent / "weights.npz"
    skin.write_text(CONFIG.replace("rows = 4", "rows = 40") + "[window]\nrows = 4\ncolumns = 5\n")
    words = ["--out", str(out), "--steps", "40", "--channels", "6", "4"]
    learned = f'[estimator]\nkind = "learned"\nweights = "{out.name}"\n'
    for trained, other in ((skin, array), (array, skin)):
        assert main(["train", str(trained), *words]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert any("with a gap of 2 to 3 pitches" in line for line in lines) == (trained == skin)
        fits, wrong = config.parent / "fits.toml", config.parent / "other.toml"
        fits.write_text(trained.read_text() + learned)
        wrong.write_text(other.read_text() + learned)
        assert load(fits).weights == out.name
        with pytest.raises(InputError, match=r"weights.npz: window: is trained for .*: run tfra train again"):
            load(wrong)


def test_a_calibration_makes_weights_of_its_own(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of CONFIG's sensor, with a state of their own; they say of which, and a warning that the cover is another."""
    out, calibration = config.parent / "weights.npz", config.parent / "cal.toml"
    words = ["train", str(config), "--out", str(out), "--steps", "40", "--channels", "6", "4"]
    files, states = [], []
    for dead, thickness in (([], 2.0), ([[1, 2]], 2.0), ([[1, 2]], 2.4)):
        calibration.write_text(CALIBRATION.format(dead=dead, thickness=thickness))
        assert main([*words, "--calibration", str(calibration)]) == 0  # those of another calibration are replaced
        fact = read_weights(out, SENSOR).prior[running.CALIBRATION]
        assert fact == {
            "gain_error": [[0.02] * 5] * 4,
            "cover": {"thickness_mm": thickness, "thickness_error_mm": 0.02, "poisson": 0.47, "poisson_error": 0.01},
            "dead": dead,
        }
        files.append(out.read_bytes())
        states.append(len(list((config.parent / "weights.npz.work").glob("*.state"))))
        told = capsys.readouterr().err
        warned = f"warning: {calibration}: cover.thickness_mm: is 2.4 +- 0.039, CONFIG says 2: "
        assert (warned in told) == (thickness > 2)
    assert len(set(files)) == 3
    assert states == [1, 2, 3]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ": has neither gain_error nor cover nor dead taxels"),
        ("gain_error = [[0.1]]", ": gain_error: 4 lists of 5 numbers are needed"),
        ('order = "columns"\ndead = [[0, 0]]', ': order: its tables are for order = "columns", [input] has "rows"'),
        ("dead = [[4, 0]]", ": dead: row 4, column 0 is no taxel"),
        (CALIBRATION.format(dead=[], thickness=1e-5).partition("\n")[2], ": cover.thickness_mm: a cover this thin"),
    ],
)
def test_a_calibration_that_does_not_fit(
    config: Path, capsys: pytest.CaptureFixture[str], text: str, words: str
) -> None:
    calibration = config.parent / "cal.toml"
    calibration.write_text(f'form = "tfra-calibration-1"\n{text}\n')
    out = config.parent / "w.npz"
    assert main(["train", str(config), "--out", str(out), "--calibration", str(calibration)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{calibration}{words}")
    assert not out.exists()


def test_a_window_has_no_calibration(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config.write_text(CONFIG.replace("rows = 4", "rows = 40") + "[window]\nrows = 4\ncolumns = 5\n")
    assert main(["train", str(config), "--out", str(config.parent / "w.npz"), "--calibration", "cal.toml"]) == 2
    reason = "--calibration: is of one array, a window's weights serve every skin"
    assert capsys.readouterr().err == f"tfra train: {reason}\n"


def rounded(config: Path, formats: str) -> Path:
    """CONFIG of a core with the weights ``start.npz``, which are trained for a few steps."""
    words = ["train", str(config), "--out", str(config.parent / "start.npz"), "--steps", "40", "--channels", "6", "4"]
    assert main(words) == 0
    file = config.parent / "core.toml"
    file.write_text(f'{CONFIG}[estimator]\nkind = "learned"\nweights = "start.npz"\n[formats]\n{formats}\n')
    return file


def test_a_training_for_short_words(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It begins with CONFIG's weights, leaves a network that is better in these words, and says which they are."""
    file = rounded(config, "coefficient_bits = 6\n[formats.signals]\noperand.first = 8")
    out = config.parent / "short.npz"
    assert main(["train", str(file), "--out", str(out), "--rounded", "--steps", "100"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"{out}: 6/4 units, 100 steps"
    found, design = read_weights(out, SENSOR), load(file).design
    assert isinstance(design, LearnedDesign)
    assert found.prior[running.ROUNDING] == Rounding(design).facts
    assert found.prior["training.rate"] == pytest.approx(0.5 * loop.RATE)
    before, after = (
        held_out(
            SENSOR, partial(Trainer(SENSOR, (6, 4), 3, lambda pieces: None, rounding=each).outputs, each.start), 50
        )
        for each in (Rounding(design), Rounding(replace(design, weights=found.weights)))
    )
    assert after["force_percent_50_at_0.001"] < before["force_percent_50_at_0.001"]
    assert after == pytest.approx(dict(found.held_out), rel=1e-2)


def test_an_interrupted_training_for_short_words_continues(config: Path, tmp_path: Path) -> None:
    design = load(rounded(config, "coefficient_bits = 6")).design
    assert isinstance(design, LearnedDesign)
    train = partial(run, SENSOR, BUDGET, rounding=Rounding(design))
    whole = train(tmp_path / "whole", silent)
    with pytest.raises(Cut):
        train(tmp_path / "cut", cutting(33))
    assert same(whole, train(tmp_path / "cut", silent))
    assert not same(whole, run(SENSOR, BUDGET, tmp_path / "cut", silent))


@pytest.mark.parametrize(
    ("formats", "more", "words"),
    [
        ("", [], ": formats: words of 18 bits or more lose nothing that a training could learn, by --rounded"),
        ("coefficient_bits = 8", ["--channels", "6", "4"], ": --channels: are those of CONFIG's weights, by --rounded"),
        ("coefficient_bits = 8", ["--out", "start.npz"], "start.npz"),
    ],
)
def test_a_training_for_short_words_that_has_nothing_to_do(
    config: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
    formats: str, more: list[str], words: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(config.parent)
    file, before = rounded(config, formats), (config.parent / "start.npz").read_bytes()
    capsys.readouterr()
    assert main(["train", str(file), "--out", "short.npz", "--rounded", *more]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert (config.parent / "start.npz").read_bytes() == before
    assert not (config.parent / "short.npz").exists()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--rounded"], ': estimator.kind: "learned" is needed, with the weights to begin with, by --rounded'),
        (["--steps", "5", "--minutes", "1"], "tfra train: --minutes: and --steps exclude each other"),
        (["--steps", "0"], "should be greater than or equal to 1"),
        (["--channels", "0", "4"], "should be greater than or equal to 1"),
        (["--seed", "-1"], "should be greater than or equal to 0"),
    ],
)
def test_bad_options(config: Path, capsys: pytest.CaptureFixture[str], more: list[str], words: str) -> None:
    assert main(["train", str(config), "--out", str(config.parent / "w.npz"), *more]) == 2
    line = capsys.readouterr().err
    assert words in line
    assert len(line.splitlines()) == 1
    assert sorted(file.name for file in config.parent.iterdir()) == ["sensor.toml"]


def test_a_file_of_somebody_else_is_not_replaced(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = config.parent / "mine.npz"
    out.write_bytes(b"mine")
    assert main(["train", str(config), "--out", str(out), "--steps", "5"]) == 2
    assert "is not replaced" in capsys.readouterr().err
    assert out.read_bytes() == b"mine"


def test_divergence_and_lack_of_memory_are_one_line(
    config: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["train", str(config), "--out", str(config.parent / "w.npz"), "--steps", "50", "--channels", "6", "4"]
    monkeypatch.setattr(loop, "RATE", 1e30)
    assert main(words) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("tfra train: the loss is not a number after")
    monkeypatch.setattr(loop, "CHUNKS", 10**10)
    assert main(words) == 2
    assert "not enough memory: Unable to allocate" in capsys.readouterr().err


def test_the_weights_of_the_example_are_as_good_as_stated() -> None:
    """Its held-out errors are those in the file, and they are small; other contacts of another seed agree."""
    file = Path(__file__).parents[2] / "examples" / "hertz_40x20.weights.npz"
    sensor = SensorArray(10, 10, 4e-3, 2e-3, 3e-3)
    trained = read_weights(file, sensor)
    network = Network(sensor, trained.weights)
    assert file.stat().st_size < 200_000
    assert held_out(sensor, network) == pytest.approx(dict(trained.held_out), rel=1e-3)  # stored in float32
    assert threshold(sensor, network) == pytest.approx(trained.threshold, rel=1e-3)
    assert trained.held_out["mu_50_at_0.001"] < 0.03
    assert trained.held_out["force_percent_95_at_0.001"] < 12
    blind = Network(sensor, replace(trained.weights, second=0 * trained.weights.second))
    assert held_out(sensor, blind, 200)["mu_50_at_0.001"] > 0.1
