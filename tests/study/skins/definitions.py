"""A small skin and frames of it for the tests of its study."""

from pathlib import Path

from tfra.study.frames.block import Block, Part
from tfra.study.skins.studyfile import SkinStudy
from tfra.study.studyfile import load_study

CONFIG = """
[sensor]
rows = 14
columns = 16
pitch_x_mm = 3.0
pitch_y_mm = 2.5
thickness_mm = 2.0

[window]
rows = 6
columns = 6

[contacts]
most = 4

[adc]
bits = 12
full_scale_pa = 200e3

[architecture]
mac_lanes = 4
"""

MIXTURE = """
[[frames.mixture]]
contacts = { from = 1, to = 4 }
gap_pitches = 0.5
shape = ["hertz", "uniform"]
half_x_pitches = { from = 0.6, to = 1.5 }
half_y_pitches = { from = 0.6, to = 1.5 }
center_x_share = { from = 0.0, to = 1.0 }
center_y_share = { from = 0.0, to = 1.0 }
peak_kpa = { from = 5.0, to = 100.0 }
mu = { from = 0.1, to = 1.0 }
phi_deg = { from = 0.0, to = 360.0 }
noise_share_of_peak = 0.02
offset_share_of_peak = 0.01
"""

STUDY = f"""
config = "skin.toml"
[frames]
train = 40
held_out = 70
{MIXTURE}
[uniform]
bits = [6, 18]
[converter]
bits = [8, 12]
noise_share_of_peak = [0.0, 0.05]
"""


def write(folder: Path, text: str = STUDY, config: str = CONFIG) -> Path:
    """The STUDY file and its CONFIG in ``folder``."""
    (folder / "skin.toml").write_text(config)
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


def study(folder: Path, text: str = STUDY) -> SkinStudy:
    """The same, read."""
    loaded = load_study(write(folder, text))
    assert isinstance(loaded, SkinStudy)
    return loaded


def a_block(folder: Path, count: int = 30) -> tuple[SkinStudy, Block]:
    """The study, and the first frames that are held out."""
    loaded = study(folder)
    return loaded, loaded.definition.source.block(Part.HELD_OUT, 0, count)
