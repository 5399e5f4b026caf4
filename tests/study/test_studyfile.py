"""STUDY files: what they mean, and the one line that says what is wrong with them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.study.definitions import ONE_MIXTURE
from tfra.runtime.errors import InputError
from tfra.study.frames.block import Part
from tfra.study.studyfile import StudyFile, load_study

EXAMPLES = Path(__file__).parents[2] / "examples"

CONFIG = """
[sensor]
rows = 6
columns = 8
pitch_x_mm = 3.0
pitch_y_mm = 2.0
thickness_mm = 2.0
"""

GOOD = f"""
config = "skin.toml"

[frames]
train = 400
held_out = 300

{ONE_MIXTURE}"""

SEARCH = GOOD + "\n[search]\ngenerations = 2\n"


@pytest.fixture
def read(tmp_path: Path) -> Any:
    def read(text: str, config: str = CONFIG) -> StudyFile:
        (tmp_path / "skin.toml").write_text(config)
        (tmp_path / "study.toml").write_text(text)
        return load_study(tmp_path / "study.toml")

    return read


@pytest.fixture
def complaint(read: Any, tmp_path: Path) -> Any:
    def complaint(text: str, config: str = CONFIG) -> str:
        with pytest.raises(InputError) as caught:
            read(text, config)
        return str(caught.value).removeprefix(f"{tmp_path}/")

    return complaint


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("study_*.toml")), ids=lambda path: path.stem)
def test_examples_are_good(path: Path) -> None:
    study = load_study(path)
    assert study.document.search or study.project.skin


def test_a_section_that_is_there_has_defaults(read: Any) -> None:
    assert read(GOOD).document.converter is None
    assert read(GOOD + "[converter]").document.converter.bits == list(range(8, 17))


def test_a_space_may_be_written_in_three_ways(read: Any) -> None:
    text = SEARCH + "[search.space]\ncoefficient.c33 = {from = 8, to = 10}\n'operand.force' = [12, 9]\nmac_lanes = 8\n"
    assert read(text).space.options == {"coefficient.c33": (8, 9, 10), "operand.force": (9, 12), "mac_lanes": (8,)}
    assert read(SEARCH).space is None


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("", "study.toml: config: is missing"),
        (GOOD.replace("peak_kpa", "force_n"), "study.toml: frames.mixture#1.force_n: -1e+06 to -1e-06 is needed, got"),
        (GOOD + "force_n = -1.0", "study.toml: frames.mixture#1.force_n: either this or peak_kpa is needed"),
        (GOOD.replace("train = 400", "train = 0"), "study.toml: frames.train: at least one is needed, got none"),
        (GOOD + "[uniform]\nbits = []", "study.toml: uniform.bits: at least one value is needed, got []"),
        (GOOD + "[verify]", "study.toml: verify: needs a section [search], whose designs it takes"),
        (SEARCH + "size = 1", "study.toml: search.size: 2 or more is needed, got 1"),
        (SEARCH + 'target = "ecp6"', "study.toml: search.target: "),
        (SEARCH + 'costs = ["LUTs"]', "study.toml: search.costs: one of coefficient_kbit, multiplier_kbit, DSP, "),
        (SEARCH + 'errors = ["mu", "mu"]', "study.toml: search.errors: one of them is there twice"),
        (SEARCH + "[search.space]\nscalar = []", "study.toml: search.space.scalar: options in rising order are needed"),
        (SEARCH + "[search.space]\nscalar = {from = 9, to = 8}", "study.toml: search.space.scalar: from 9 to 8 is no"),
        (SEARCH + "[search.space]\nscalar = [true]", "study.toml: search.space.scalar: whole numbers, a list or {"),
        (SEARCH.replace("held_out = 300", "held_out = 0"), "study.toml: frames.held_out: [search] needs 200 or more"),
    ],
)
def test_bad_input_is_one_line(text: str, start: str, complaint: Any) -> None:
    line = complaint(text)
    assert line.startswith(start)
    assert "\n" not in line


def test_a_recording_is_read_as_config_says(read: Any, tmp_path: Path) -> None:
    """In kPa, compression positive; a recording of tfra frames would be in Pa whatever CONFIG says."""
    frames = np.random.default_rng(1).normal(size=(6, 6, 8))
    np.save(tmp_path / "r.npy", -frames)
    text = 'config = "skin.toml"\n[frames]\ntrain = 4\nheld_out = 2\nrecording = "r.npy"\n'
    found = read(text, CONFIG + '[input]\nunit = "kPa"\ncompression = "positive"\n').definition.make(Part.TRAIN, 0)
    np.testing.assert_array_equal(found.stress, (1000.0 * frames[:4]).astype(np.float32))


def test_a_part_of_another_family(complaint: Any) -> None:
    line = complaint(SEARCH, CONFIG + '[target]\nname = "ice40"')
    assert line.startswith("study.toml: search.target: ecp5-45-6 has no cells of ice40")


def test_formats_that_overflow_are_refused_before_any_frame(complaint: Any) -> None:
    dense = CONFIG.replace("rows = 6", "rows = 12").replace("x_mm = 3.0", "x_mm = 0.6")
    line = complaint(GOOD, dense.replace("y_mm = 2.0", "y_mm = 0.6"))
    assert line.startswith("skin.toml: ")
