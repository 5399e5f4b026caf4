"""A sensor and definitions of frames for the tests of studies."""

import tomllib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import polars as pl

from tfra.codegen.config.cover import LayerSpec
from tfra.model.choices import Adc, Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.frames.schema import FramesSection
from tfra.study.tasks import Task

SENSOR = SensorArray(6, 8, 3e-3, 2e-3, 2e-3)
LAYER = LayerSpec(poisson=0.48, sampling="point")

ONE_MIXTURE = """\
[[frames.mixture]]
shape = "hertz"
half_x_pitches = {from = 0.6, to = 1.5}
half_y_pitches = 1.0
center_x_share = 0.5
center_y_share = 0.5
peak_kpa = {from = 20.0, to = 150.0}
mu = 0.5
phi_deg = {from = 0.0, to = 360.0}
"""
"""The only mixture of a STUDY file."""

MIXTURE = """
train = 40
held_out = 12
seed = 7

[[mixture]]
weight = 3
shape = ["hertz", "rounded"]
half_x_pitches = {from = 0.5, to = 2.5, log = true}
half_y_pitches = [1, 1.5, 2]
center_x_share = {from = 0, to = 1}
center_y_share = 0.25
force_n = {from = -10, to = -1}
mu = {from = 0, to = 1}
phi_deg = {from = 0, to = 360}
noise_share_of_peak = 0.001
offset_share_of_peak = [-0.005, 0, 0.005]

[[mixture]]
weight = 1
shape = "uniform"
half_x_pitches = 1
half_y_pitches = 1
center_x_share = {from = 0, to = 1}
center_y_share = 0.5
force_n = -2
mu = [0, 0.5]
phi_deg = 30
"""


def section(text: str = MIXTURE, **changes: Any) -> FramesSection:
    """The ``[frames]`` section in ``text``, with some keys changed."""
    return FramesSection.model_validate(tomllib.loads(text) | changes)


def definition(text: str = MIXTURE, **changes: Any) -> Definition:
    """The same as a definition, of a file in the current folder."""
    return Definition.of(Path("study.toml"), SENSOR, LAYER, section(text, **changes))


def complete(folder: Path, definition: Definition) -> FrameSet:
    """All frames of a definition in a folder."""
    frames = FrameSet.create(folder, definition)
    for block in frames.missing():
        frames.write(block)
    return frames


def design(**changes: Any) -> TfraDesign:
    """A core for the sensor, whose converter clips a few of the frames."""
    return TfraDesign(SENSOR, adc=Adc(bits=12, full_scale=400e3), architecture=Architecture(8), **changes)


def tables_of(task: Task) -> dict[str, pl.DataFrame]:
    """The tables of a task whose jobs are done here."""
    pieces = list(map(task, task.jobs))
    return dict(task.tables(pieces.__getitem__))


def one_after_another(do: Callable[[Any], Any], jobs: Sequence[Any]) -> Iterator[tuple[int, Any]]:
    """Workers that are this process."""
    yield from ((number, do(job)) for number, job in enumerate(jobs))
