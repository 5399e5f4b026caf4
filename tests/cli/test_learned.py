"""The learned estimator in the commands and in the library."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from tests.cli.test_cli import CONFIG, refusal
from tests.cli.test_live import live, values
from tests.model.fixed.learned.cases import learned_design
from tests.model.learned.random_weights import random_weights
from tests.study.definitions import ONE_MIXTURE
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.codegen.config.weights import Trained, read_weights, write_weights
from tfra.model.learned.network import Learned
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status
from tfra.recordings.facts import RESULTANT_ALONE

SENSOR = SensorArray(5, 6, 4e-3, 4e-3, 3e-3)
ESTIMATOR = '[estimator]\nkind = "learned"\nweights = "lab/w.npz"\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a CONFIG of the learned estimator, its weights and frames."""
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(CONFIG + ESTIMATOR)
    Path("lab").mkdir()
    weights = random_weights(np.random.default_rng(0), SENSOR.taxels, 3, 2)
    write_weights("lab/w.npz", Trained(SENSOR, weights, 0.25))
    assert main(["frames", "skin.toml", "--out", "frames.npz"]) == 0
    return tmp_path


def stress() -> np.ndarray:
    with np.load("frames.npz") as archive:
        return np.array(archive["frames"])


def estimator() -> Learned:
    adc = load("skin.toml").design.adc
    return Learned(SENSOR, read_weights(Path("lab/w.npz"), SENSOR).weights, 0.25, adc.threshold * adc.lsb)


def test_the_float_engine_is_the_learned_estimator(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["estimate", "skin.toml", "frames.npz", "--out", "r.npz", "--json"]) == 0
    told, expected = json.loads(capsys.readouterr().out), estimator()(stress())
    assert told["summary"]["threshold_percent"] == 25
    assert told["friction"] is None
    assert told["summary"]["ranges"]["uncertainty_percent"]["max"] == 100 * expected.uncertainty_share.max()
    assert told["status"]["IMPLAUSIBLE"] == int((expected.status & Status.IMPLAUSIBLE != 0).sum())
    with np.load("r.npz") as found:
        assert found["threshold"] == 0.25
        for key in ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status", "residual"):
            assert np.array_equal(found[key], getattr(expected, key)), key
        assert 'weights = "lab/w.npz"' in str(found["config"])


def test_a_core_without_forces_at_the_taxels_has_a_page(capfd: pytest.CaptureFixture[str]) -> None:
    short = CONFIG + ESTIMATOR + 'taxel_forces = false\n[architecture]\nkind = "serial"\n'
    Path("skin.toml").write_text(short)
    assert main(["estimate", "skin.toml", "frames.npz", "--engine", "fixed", "--out", "r.npz"]) == 0
    with np.load("r.npz") as found:
        assert np.isnan(found["forces"]).all()
    said = capfd.readouterr().out
    assert RESULTANT_ALONE in said.splitlines()
    assert "TFRA" not in said
    assert main(["view", "r.npz", "--out", "page.html"]) == 0
    data = Path("page.html").read_text().partition('id="data">')[2].partition("</script>")[0]
    assert json.loads(data, parse_constant=pytest.fail)["results"][0].keys().isdisjoint({"forces", "sweep"})


def test_such_a_core_is_shown_live() -> None:
    Path("skin.toml").write_text(CONFIG + ESTIMATOR + 'taxel_forces = false\n[architecture]\nkind = "serial"\n')
    assert main(["estimate", "skin.toml", "frames.npz", "--engine", "fixed", "--out", "r.npz"]) == 0
    with live("frames.npz", "--engine", "fixed", "--rate", "1000") as running, np.load("r.npz") as held:
        found = running.until(state="ended", estimated=len(held["mu"]))
        assert all("forces" not in piece["results"][0] for piece in found["pieces"])
        share = 100 * held["uncertainty"] / np.abs(held["resultant"][:, 2])
        np.testing.assert_allclose(values(found, "uncertainty"), share, rtol=1e-6)
        np.testing.assert_allclose(values(found, "f_x"), held["resultant"][:, 0], rtol=1e-6)


def test_a_study_of_it_beside_tfra(capfd: pytest.CaptureFixture[str]) -> None:
    """The designs that it finds are CONFIG files that load, with the weights beside them."""
    write_weights("lab/w.npz", Trained(SENSOR, learned_design(5, 6).weights, 100.0))
    Path("tfra.toml").write_text(CONFIG)
    sections = "[frames]\ntrain = 250\nheld_out = 250\n" + ONE_MIXTURE + "[search]\ngenerations = 1\nsize = 4\n"
    sections += "baseline = false\ngive_up_percent = 1000\n[search.space]\nforce_fraction = [4, 6]\n"
    Path("study.toml").write_text('config = "skin.toml"\nbeside = ["tfra.toml"]\n' + sections)
    assert main(["study", "study.toml", "--out", "out", "--workers", "1"]) == 0
    assert set(pl.read_parquet("out/tables/estimators.parquet")["design"]) == {"skin", "tfra"}
    (found, *_) = Path("out/designs").glob("*.toml")
    assert load(found).design.estimator == "learned"
    assert "Estimators side by side" in Path("out/index.html").read_text()
    Path("tfra.toml").write_text(CONFIG.replace("pitch_x_mm = 4", "pitch_x_mm = 5"))
    assert refusal(capfd, "study", "study.toml", "--out", "out") == (
        "study.toml: beside#1: tfra.toml is of another sensor than skin.toml"
    )


def test_better_weights_are_kept(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    """Those of the same sensor; the new ones are beside them, and replace them if they are forced to or are better."""
    key = "force_percent_50_at_0.001"

    def reached(error: float) -> list[str]:
        weights = random_weights(np.random.default_rng(int(error)), SENSOR.taxels, 3, 2)
        trained = Trained(SENSOR, weights, 0.25, {"training.steps": 1}, {key: error})
        monkeypatch.setattr("tfra.train.run.run", lambda *_: trained)
        return ["train", "skin.toml", "--out", "lab/w.npz", "--json"]

    def errors() -> float:
        return read_weights(Path("lab/w.npz"), SENSOR).held_out[key]

    assert main(reached(4.0)) == 0  # those before state no error
    capfd.readouterr()
    assert main(reached(48.0)) == 1
    out, err = capfd.readouterr()
    assert json.loads(out)["out"] == "lab/w.new.npz"
    assert err == (
        "tfra train: lab/w.npz: has better weights, with a held-out error of 4.0 % of |F|, not 48.0 %; "
        "the new ones are w.new.npz, --force replaces\n"
    )
    assert errors() == 4.0
    assert read_weights(Path("lab/w.new.npz"), SENSOR).held_out[key] == 48.0
    assert main([*reached(48.0), "--force"]) == 0
    assert errors() == 48.0
    assert main(reached(3.0)) == 0
    assert errors() == 3.0
