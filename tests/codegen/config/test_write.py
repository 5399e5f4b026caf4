"""A CONFIG that is written from a design is read as that design."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.model.learned.random_weights import random_weights
from tfra.codegen.config.cover import LayerSpec
from tfra.codegen.config.read import load
from tfra.codegen.config.weights import Trained, write_weights
from tfra.codegen.config.write import config_text
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Bus, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import SIGNALS, TfraDesign
from tfra.model.sensor import SensorArray

LAYER = LayerSpec(0.47, "area", "series", 0.00041)
PLAIN = TfraDesign(SensorArray(8, 12, 3e-3, 2.5e-3, 2.1e-3), name="skin")


def read(design: Design, folder: Path, layer: LayerSpec = LAYER) -> Design:
    path = folder / "other_name.toml"
    path.write_text(config_text(design, layer, "Two lines\nof comment."))
    found = load(path)
    assert found.layer == layer
    return found.design


@pytest.mark.parametrize(
    "design",
    [
        PLAIN,
        replace(PLAIN, formats=FORMATS["wide"], architecture=SERIAL),
        replace(PLAIN, adc=Adc(12, 123456.789, 7), search=Search(33, 0.1), images="load", target="ecp5"),
        replace(PLAIN, architecture=Architecture(8, 2), images="readmemh", bus=Bus(4)),
        replace(
            PLAIN,
            formats=replace(
                FORMATS["standard"], name="custom", coefficient=13, signals=(("coefficient.c33", 11), ("scalar", 16))
            ),
        ),
    ],
)
def test_a_written_config_is_the_design(design: Design, tmp_path: Path) -> None:
    assert read(design, tmp_path) == design


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    pitch=st.floats(0.1, 9.0),
    thickness=st.floats(0.1, 9.0),
    lengths=st.dictionaries(st.sampled_from([s for s in SIGNALS if "." in s]), st.integers(14, 18)),
)
def test_any_lengths_and_words_come_back(
    pitch: float, thickness: float, lengths: dict[str, int], tmp_path: Path
) -> None:
    """Lengths in metres as a CONFIG in millimetres can have them."""
    sensor = SensorArray(4, 6, *(float(f"{value:.6g}") / 1000 for value in (pitch, pitch, thickness)))
    sensor = replace(sensor, **{key: round(getattr(sensor, key), 9) for key in ("pitch_x", "pitch_y", "thickness")})
    formats = replace(FORMATS["standard"], name="custom", signals=tuple(lengths.items()))
    design = TfraDesign(sensor, name="skin", formats=formats, architecture=Architecture(8))
    assert read(design, tmp_path) == design


def test_the_comment_is_on_top(tmp_path: Path) -> None:
    assert config_text(PLAIN, LAYER, "Two lines\nof comment.").startswith('# Two lines\n# of comment.\nname = "skin"\n')


@pytest.mark.parametrize("forces", [True, False])
@pytest.mark.parametrize("name", ["w.npz", 'lab/"odd" name\\.npz'])
def test_weights_come_back(name: str, forces: bool, tmp_path: Path) -> None:
    path = tmp_path / "skin.toml"
    (tmp_path / name).parent.mkdir(exist_ok=True)
    weights = random_weights(np.random.default_rng(0), PLAIN.sensor.taxels, 3, 2)
    write_weights(tmp_path / name, Trained(PLAIN.sensor, weights, 0.3))
    given = {each.name: getattr(PLAIN, each.name) for each in fields(PLAIN)}
    design = LearnedDesign(**given, weights=weights, threshold=0.3, taxel_forces=forces)
    path.write_text(config_text(design, LAYER, "", name))
    found = load(path)
    assert found.weights == name
    assert isinstance(found.design, LearnedDesign)
    assert (found.design.threshold, found.design.taxel_forces) == (0.3, forces)
    assert {each.name: getattr(found.design, each.name) for each in fields(PLAIN)} == given


def test_tfra_has_no_weights(tmp_path: Path) -> None:
    path = tmp_path / "skin.toml"
    path.write_text(config_text(PLAIN, LAYER, ""))
    assert (load(path).design, load(path).weights) == (PLAIN, None)
