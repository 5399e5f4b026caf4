"""A recording as a logger would have written it: ``examples/recording_8x12.csv``, of docs/first_hour.md.

``python -m docs.tools.recording`` writes it: a ball comes down on the 8×12 sensor of that page, is dragged, and
lifted.  Time stamps come first, compression is positive, the unit is kPa, and every taxel has an offset.
"""

import csv
import io
import math
from pathlib import Path

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.cover.layer import frames
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(8, 12, 3e-3, 2.5e-3, 3e-3)
REST, PRESS, DRAG = 20, 15, 40
"""Frames at rest at either end, of pressing and of lifting, and of the drag."""
MU, PHI_DEG, FORCE, HALF, WAY = 0.5, 25.0, -8.0, 5e-3, 8e-3
"""Of the ball: friction and direction of the drag, force in N; radius of the contact and length of the drag, in m."""
RATE_HZ, BITS, FULL_SCALE_KPA, OFFSET_KPA, SEED = 100, 12, 150.0, 3.0, 1
PATH = Path(__file__).parents[2] / "examples" / "recording_8x12.csv"


def stress() -> Floats:
    """What the taxels would measure without offsets, in Pa, compression negative."""
    rise = np.arange(1, PRESS + 1) / PRESS
    force = FORCE * np.concatenate([rise, np.ones(DRAG), rise[::-1]])
    way = np.concatenate([np.zeros(PRESS), np.linspace(0, 1, DRAG), np.ones(PRESS)])
    friction = MU * np.concatenate([np.zeros(PRESS), np.clip(np.linspace(0, 3, DRAG), 0, 1), np.ones(PRESS)])
    contacts = [
        Contact(
            shape=ContactShape.HERTZ,
            half_x=HALF,
            half_y=HALF,
            normal_force=float(f),
            mu=float(m),
            phi=math.radians(PHI_DEG),
            center_x=SENSOR.pitch_x * (SENSOR.columns - 1) / 2 + WAY * (float(w) - 0.5),
            center_y=SENSOR.pitch_y * (SENSOR.rows - 1) / 2,
        )
        for f, m, w in zip(force, friction, way, strict=True)
    ]
    rest = np.zeros((REST, SENSOR.rows, SENSOR.columns))
    return np.concatenate([rest, frames(SENSOR, contacts), rest])


def text() -> str:
    """The file."""
    rng = np.random.default_rng(SEED)
    offset = rng.uniform(-OFFSET_KPA, OFFSET_KPA, (SENSOR.rows, SENSOR.columns))
    step = 2 * FULL_SCALE_KPA / 2**BITS
    kpa = step * np.round((offset - stress() / 1e3) / step)
    stream = io.StringIO()
    stream.write(f"# A ball of {abs(FORCE):g} N, dragged at mu = {MU} towards {PHI_DEG:g} degrees (simulated)\n")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["t_s", *(f"r{row}c{column}" for row in range(SENSOR.rows) for column in range(SENSOR.columns))])
    for number, frame in enumerate(kpa):
        writer.writerow([f"{number / RATE_HZ:.2f}", *(f"{value + 0.0:.3f}" for value in frame.ravel())])
    return stream.getvalue()


if __name__ == "__main__":
    PATH.write_text(text())
