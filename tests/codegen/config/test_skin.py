"""CONFIG files of skins: what they mean, and what is wrong with them."""

from pathlib import Path

import numpy as np
import pytest

from tfra.codegen.config.read import Project, load
from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding
from tfra.model.skin.skin import Skin
from tfra.runtime.errors import InputError

SKIN = """
[sensor]
rows = 100
columns = 128
pitch_x_mm = 4
pitch_y_mm = 2.0
thickness_mm = 3.0

[window]
rows = 6
columns = 5
"""

CONTACT = """
[[contact]]
shape = "hertz"
center_x_mm = {x}
half_x_mm = 8
half_y_mm = 4
force_n = -5.73
mu = 0.5
phi_deg = {phi}
"""


def read(folder: Path, text: str) -> Project:
    (folder / "sensor.toml").write_text(text)
    return load(folder / "sensor.toml")


def test_a_section_window_makes_a_skin(tmp_path: Path) -> None:
    project = read(tmp_path, SKIN)
    skin = project.skin
    assert skin
    assert project.array is skin
    assert skin.sensor == SensorArray(100, 128, 4e-3, 2e-3, 3e-3)
    assert project.design is skin.window
    assert project.design.sensor == SensorArray(6, 5, 4e-3, 2e-3, 3e-3)
    assert skin.choices == Finding()
    assert project.contacts == ()


def test_contacts_are_told_apart_as_it_says(tmp_path: Path) -> None:
    skin = read(tmp_path, SKIN + "[contacts]\nmost = 3\nthreshold = 0.5\ngap = 1\n").skin
    assert isinstance(skin, Skin)
    assert skin.choices == Finding(3, 0.5, 1)


def test_without_one_it_is_an_array(tmp_path: Path) -> None:
    project = read(tmp_path, SKIN.partition("[window]")[0].replace("100", "10").replace("128", "10"))
    assert project.skin is None
    assert project.array is project.design
    assert project.frame is None


def test_contacts_act_together(tmp_path: Path) -> None:
    text = SKIN + CONTACT.format(x=100, phi=[0, 90, 180]) + CONTACT.format(x=200, phi=45)
    project = read(tmp_path, text)
    assert project.frame is not None
    assert project.frame.tolist() == [0, 0, 1, 1, 2, 2]
    assert [round(1e3 * each.center_x) for each in project.contacts] == [100, 200] * 3
    degrees = np.degrees([each.phi for each in project.contacts])
    np.testing.assert_allclose(degrees, [0, 45, 90, 45, 180, 45])


def test_its_text_makes_the_same_skin(tmp_path: Path) -> None:
    project = read(tmp_path, SKIN + "[contacts]\nmost = 3\n")
    again = read(tmp_path, project.text())
    assert again.skin == project.skin
    assert again.layer == project.layer


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (SKIN.replace("100", "129"), "sensor.rows: at most 128 are supported, got 129"),
        (SKIN.replace("rows = 6", "rows = 101"), "window.rows: at most the array's 100 are supported, got 101"),
        (SKIN.replace("rows = 6", "rows = 1"), "window.rows: at least 2 taxels are needed, got 1"),
        (
            SKIN.replace("rows = 6", "rows = 99").replace("columns = 5", "columns = 99"),
            "window.rows: at most 4096 taxels (rows x columns) are supported, got 9801",
        ),
        (SKIN.replace("rows = 6\n", ""), "window.rows: is missing"),
        (SKIN + "[contacts]\nmost = 65\n", "contacts.most: 1 to 64 is supported, got 65"),
        (SKIN + "[contacts]\ngap = 5\n", "contacts.gap: 0 to 4 is supported, got 5"),
        (SKIN + "[contacts]\nthreshold = 0\n", "contacts.threshold: 0.0039 to 1 is supported, got 0.0"),
        (
            "[contacts]\nmost = 3\n" + SKIN.partition("[window]")[0].replace("100", "10").replace("128", "10"),
            "contacts: belongs to a skin: a section window is needed",
        ),
        (
            SKIN + CONTACT.format(x=100, phi=[0, 90, 180]) + CONTACT.format(x=200, phi=[0, 1]),
            "contact#2.phi_deg: contacts of a skin act together: 1 or 3 directions are needed, got 2",
        ),
    ],
)
def test_wrong_content(tmp_path: Path, text: str, line: str) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert str(caught.value) == f"{tmp_path / 'sensor.toml'}: {line}"
