"""A CONFIG that is written from a design is read as that design."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tfra.codegen.config import load
from tfra.codegen.configfile import config_text
from tfra.codegen.cover import LayerSpec
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Search
from tfra.model.fixed.design import Design
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
        replace(PLAIN, architecture=Architecture(8, 2), images="readmemh"),
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


@pytest.mark.parametrize("weights", [None, "w.npz", 'lab/"odd" name\\.npz'])
def test_weights_come_back(weights: str | None, tmp_path: Path) -> None:
    path = tmp_path / "skin.toml"
    path.write_text(config_text(PLAIN, LAYER, "", weights))
    found = load(path)
    assert (found.design, found.weights) == (PLAIN, weights)
