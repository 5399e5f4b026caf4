"""A CONFIG that is written from a design is read as that design, and that of ``tfra init`` explains every key."""

import re
import tomllib
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.model.learned.random_weights import random_weights
from tfra.codegen.config.cover import LayerSpec
from tfra.codegen.config.examples import examples, write_examples
from tfra.codegen.config.read import Project, build_project, load
from tfra.codegen.config.schema import Document
from tfra.codegen.config.weights import Trained, write_weights
from tfra.codegen.config.write import EXAMPLE, commented, config_text
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Bus, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import SIGNALS, TfraDesign
from tfra.model.sensor import SensorArray

LAYER = LayerSpec(0.47, "area", "series", 0.00041)
PLAIN = TfraDesign(SensorArray(8, 12, 3e-3, 2.5e-3, 2.1e-3), name="skin")


def read(design: Design, folder: Path) -> Design:
    path = folder / "other_name.toml"
    text = config_text(design, LAYER, "Two lines\nof comment.")
    assert text.startswith('# Two lines\n# of comment.\nname = "skin"\n')
    path.write_text(text)
    found = load(path)
    assert (found.layer, found.weights) == (LAYER, None)
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


def content(text: str) -> Project:
    return build_project(tomllib.loads(text), Path("skin.toml"))


@settings(max_examples=15, deadline=None)
@given(
    size=st.tuples(st.integers(2, 12), st.integers(2, 12)),
    lengths=st.lists(st.integers(800, 9800), min_size=3, max_size=3),
    adc=st.builds(Adc, st.integers(6, 18), st.floats(2e3, 9e6)),
    architecture=st.sampled_from([Architecture(4), SERIAL]),
    family=st.sampled_from(["portable", "ecp5", "ice40"]),
)
def test_init_gives_the_design_and_no_frame_over_full_scale(
    size: tuple[int, int], lengths: list[int], adc: Adc, architecture: Architecture, family: str
) -> None:
    sensor = SensorArray(*size, *(micrometres / 1e6 for micrometres in lengths))
    design = TfraDesign(sensor, name="skin", adc=adc, architecture=architecture, target=family)
    found = content(commented(design, LAYER))
    assert (found.design, found.layer) == (design, LAYER)
    frames = found.layer.frames(sensor, found.contacts)
    assert len(frames) == 24
    peak = np.abs(frames).max(axis=(1, 2))
    assert (peak < adc.full_scale).all()
    assert (peak >= adc.lsb).all()


def test_every_key_has_a_comment_and_is_there() -> None:
    """The example is the one home of these comments: it has each key of the schema, and so has the new file."""
    needed = set()
    for name, field in Document.model_fields.items():
        kind = getattr(field.annotation, "__args__", (field.annotation,))[0]
        keys = getattr(kind, "model_fields", None)
        needed |= {("", name)} if keys is None else {(name, key) for key in keys}
    assert len(needed) > 40
    for text in (examples()[EXAMPLE], commented(PLAIN, LAYER)):
        section, found = "", set()
        for line in text.splitlines():
            if head := re.match(r"(?:# )?\[+(\w+)\]+", line):
                section = head[1]
            elif key := re.match(r"(?:# )?(\w+) = .*? # \w*", line):
                found.add((section, key[1]))
        assert needed - found == {("formats", "signals")}  # a table of its own, docs/numerics.md


def test_what_is_commented_out_is_the_default() -> None:
    """With all of it switched on, one at a time, the design and the places of contacts stay."""
    text = commented(replace(PLAIN, adc=Adc(12, 150e3)), LAYER)
    plain = content(text)
    keys = ["name", "contact_threshold_codes", "center_x_mm", "center_y_mm"]
    keys += [f"{name}_bits" for name in ("coefficient", "operand", "vector_fraction", "force_fraction")]
    for key in [*keys, "unit", "compression", "tare_frames", "order", "flip_x", "flip_y", "skip_columns"]:
        changed = re.sub(rf"(?m)^# ({key} = )", r"\1", text).replace("# [input]", "[input]")
        assert changed != text
        found = content(changed)
        assert found.design.adc.threshold == plain.design.adc.threshold
        assert (found.contacts, found.input) == (plain.contacts, plain.input)
        assert replace(found.design.formats, name="standard") == FORMATS["standard"]


def test_remarks_on_the_example_are_left_out() -> None:
    assert "72 kPa" in examples()[EXAMPLE]
    assert not re.search("72 kPa|hertz_40x20", commented(PLAIN, LAYER))


def test_examples_are_those_of_the_folder(tmp_path: Path) -> None:
    """They are written with what they read."""
    folder = Path(__file__).parents[3] / "examples"
    assert examples() == {path.name.removesuffix(".toml"): path.read_text() for path in folder.glob("*.[tc]*")}
    names = ["hertz_40x20.toml", "hertz_40x20.weights.npz", "recording_8x12.csv", "study_hertz.toml"]
    assert write_examples(tmp_path / "out", ["study_hertz", "recording_8x12.csv"]) == names
    assert all((tmp_path / "out" / name).read_bytes() == (folder / name).read_bytes() for name in names)
