"""Simulated sensors with everything wrong that a real one has, and recordings of known loads on them.

The stress is that of the exact series (:class:`tfra.model.cover.layer.ElasticLayer`), of Hertz contacts.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tfra.model.arrays import Bools, Floats
from tfra.model.choices import Adc
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import ElasticLayer
from tfra.model.sensor import SensorArray
from tfra.recordings.front_end import Array
from tfra.recordings.input import Input, Order, arranged

GAINS, OFFSETS, THICKNESS, NOISE, DEAD = 0.3, 0.1, 0.2, 0.003, 0.05
"""Largest deviations of gains and thickness, relative; offsets and noise of a frame over full scale; share that is."""

WANDER = 5e-4
"""Standard deviation of an offset's step from recording to recording, over full scale; it drifts as much within one."""

REST, RAMP, HELD = 30, 5, 40
"""Frames before a load, while it comes and goes, and under it; after it two thirds of those before."""

WEIGHED = 0.005
"""Standard deviation of the forces in the table, relative."""

_FIELDS = ("recording", "force_n", "tangential_n", "direction_deg", "radius_mm")


@dataclass(frozen=True, eq=False)
class Loads:
    """Hertz contacts: places and radii ``(n,)``, m, and forces ``(n, 3)``, N."""

    x: Floats
    y: Floats
    radius: Floats
    force: Floats

    def stress(self, sensor: SensorArray, layer: ElasticLayer) -> Floats:
        """Frames ``(n, rows, columns)`` in Pa, compression negative."""
        both = np.stack([self.radius, self.radius], axis=1)
        shapes = np.array(["hertz"] * len(self.x))
        contacts = Contacts(shapes, np.stack([self.x, self.y], axis=1), both, self.force)
        return layer.base_stress(
            contacts, np.arange(sensor.columns) * sensor.pitch_x, np.arange(sensor.rows) * sensor.pitch_y
        )


class Sensor:
    """A sensor of the random numbers ``rng``: its truth, and recordings of loads as its converter writes them.

    ``thickness``: the largest deviation of the cover's from that of ``nominal``.
    """

    def __init__(self, nominal: SensorArray, rng: np.random.Generator, thickness: float = THICKNESS) -> None:
        self.nominal, self.rng = nominal, rng
        self.shape = nominal.rows, nominal.columns
        self.thickness = nominal.thickness * (1 + rng.uniform(-thickness, thickness))
        margin = 3 * self.thickness * int(rng.integers(2))
        self.layer = ElasticLayer.under(nominal, rng.uniform(0.45, 0.49), self.thickness, margin)
        self.gain: Floats = 1 + rng.uniform(-GAINS, GAINS, self.shape)
        dead = np.zeros(nominal.taxels, dtype=np.bool_)
        dead[rng.choice(nominal.taxels, round(DEAD * nominal.taxels), replace=False)] = True
        self.offset: Floats = np.zeros(self.shape)
        self.dead: Bools = dead.reshape(self.shape)
        orders: tuple[Order, Order] = ("rows", "columns")
        self.given = Input(
            "codes",
            "positive",
            "unipolar",
            order=orders[rng.integers(2)],
            flip_x=bool(rng.integers(2)),
            flip_y=bool(rng.integers(2)),
        )

    def loads(self, normal: int, pulled: int, pull: tuple[float, float] = (0.15, 0.6)) -> Loads:
        """``normal`` presses of 1 to 20 N anywhere, and ``pulled`` ones of 4 to 12 N with frictions within ``pull``."""
        rng, sensor, count = self.rng, self.nominal, normal + pulled
        force = np.exp(rng.uniform(0.0, math.log(20.0), count))
        force[normal:] = rng.uniform(4.0, 12.0, pulled)
        radius = rng.uniform(0.5, 1.3) * sensor.thickness * (force / 20) ** rng.uniform(0.25, 0.34)
        friction = np.where(np.arange(count) < normal, 0.0, rng.uniform(*pull, count))
        phi = rng.uniform(-np.pi, np.pi, count)
        across = np.stack([friction * np.cos(phi), friction * np.sin(phi), -np.ones(count)], axis=1)
        inside = 1.001 * radius
        x = rng.uniform(inside - sensor.pitch_x / 2, (sensor.columns - 0.5) * sensor.pitch_x - inside)
        y = rng.uniform(inside - sensor.pitch_y / 2, (sensor.rows - 0.5) * sensor.pitch_y - inside)
        return Loads(x, y, radius, force[:, None] * across)

    def day(self, folder: Path, loads: Loads) -> "Day":
        """Recordings of the array at rest and of ``loads``, and their table, in ``folder``."""
        stress = loads.stress(self.nominal, self.layer)
        self._choose_converter(stress)
        profile = np.concatenate(
            [
                np.zeros(REST),
                np.linspace(0, 1, RAMP + 2)[1:-1],
                np.ones(HELD),
                np.linspace(1, 0, RAMP + 2)[1:-1],
                np.zeros(REST * 2 // 3),
            ]
        )
        true = 1 + WEIGHED * self.rng.standard_normal(len(stress))
        files = [self._record(folder / "rest.npy", np.zeros((100, *self.shape)))]
        rows = [("rest", "", "", "", "")]
        for at, (frame, force) in enumerate(zip(stress * true[:, None, None], loads.force, strict=True)):
            files.append(self._record(folder / f"load{at}.npy", profile[:, None, None] * frame))
            pull = float(np.hypot(force[0], force[1]))
            angle = f"{math.degrees(math.atan2(force[1], force[0])):.3f}" if pull else ""
            rows.append((f"load{at}", f"{-force[2]:.6g}", f"{pull:.6g}" if pull else "", angle, "10"))
        table = folder / "loads.csv"
        with table.open("w", newline="") as stream:
            csv.writer(stream).writerows([_FIELDS, *rows])
        return Day(Array(self.nominal, self.adc), files, table)

    def codes(self, stress: Floats) -> Floats:
        """What the converter writes for frames ``(n, rows, columns)`` in Pa, ``(n, taxels)``; the offsets move on."""
        full, rng = 2.0**self.adc.bits, self.rng
        along = np.linspace(0, 1, len(stress))[:, None, None]
        offset = self.offset + along * WANDER * full * rng.standard_normal(self.shape)
        levels = offset - stress / self.gain / self.pascals + NOISE * full * rng.standard_normal(stress.shape)
        whole = np.clip(np.rint(levels), 0, full - 1)
        whole[:, self.dead] = 77.0
        self.offset = offset[-1] + WANDER * full * rng.standard_normal(self.shape)
        place = arranged(np.arange(self.nominal.taxels, dtype=np.float64)[None], self.given, self.nominal)[0]
        flat = np.empty((len(stress), self.nominal.taxels))
        flat[:, place.astype(np.int64).ravel()] = whole.reshape(len(stress), -1)
        return flat

    def _record(self, file: Path, stress: Floats) -> Path:
        np.save(file, self.codes(stress).astype(np.int16))
        return file

    def _choose_converter(self, stress: Floats, bits: int = 12) -> None:
        """All gains and offsets fit its range, which is that of one sign: a bit more has the stress of both."""
        reach = float(np.abs(stress).max()) / (1 - GAINS) / (0.9 - OFFSETS)
        self.adc = Adc(bits, 2 * reach)
        self.pascals = reach / 2.0**bits
        self.offset = 2.0**bits * self.rng.uniform(0.02, OFFSETS, self.shape)


@dataclass(frozen=True)
class Day:
    """What a day with a sensor leaves: the array as CONFIG has it, recordings, and the table of their loads."""

    array: Array
    files: list[Path]
    table: Path
