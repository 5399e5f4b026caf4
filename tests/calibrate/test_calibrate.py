"""Calibrations of simulated sensors, whose truth is known, and what is told of wrong ones."""

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.accuracy.calibration import ARRAYS, SEED, measured
from bench.accuracy.sensors import Day, Loads, Sensor
from tfra.calibrate.advice import advice, best_press
from tfra.calibrate.calibrated import Calibrated
from tfra.calibrate.doubts import doubts
from tfra.calibrate.files import write
from tfra.calibrate.run import calibrate
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import read_calibration
from tfra.recordings.input import Input
from tfra.runtime.errors import InputError

NOMINAL = SensorArray(*ARRAYS[0])


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> tuple[Sensor, Loads, Day]:
    sensor = Sensor(NOMINAL, np.random.default_rng(3))
    loads = sensor.loads(30, 4)
    return sensor, loads, sensor.day(tmp_path_factory.mktemp("day"), loads)


@pytest.fixture(scope="module")
def found(day: tuple[Sensor, Loads, Day]) -> Calibrated:
    return run(*day)


def given(sensor: Sensor) -> Input:
    return Input("codes", "positive", "unipolar", pa_per_code=sensor.pascals)


def run(sensor: Sensor, loads: Loads, day: Day, config: Input | None = None) -> Calibrated:
    return calibrate(day.array, config or given(sensor), day.files, day.table, lambda title: None)


def changed(day: Day, folder: Path, change: Callable[[list[dict[str, str]]], list[dict[str, str]]]) -> Day:
    """The same day with another table, and the files that it names."""
    rows = list(csv.DictReader(day.table.read_text().splitlines()))
    kept = change(rows)
    table = folder / "loads.csv"
    with table.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(kept)
    names = {row["recording"] for row in kept}
    return replace(day, table=table, files=[file for file in day.files if file.stem in names])


def test_a_sensor_is_found_as_it_is(day: tuple[Sensor, Loads, Day], found: Calibrated) -> None:
    sensor, loads, _ = day
    assert (found.given.order, found.given.flip_x, found.given.flip_y) == (
        sensor.given.order, sensor.given.flip_x, sensor.given.flip_y,
    )  # fmt: skip
    assert found.orientation.is_sure
    assert (found.dead == sensor.dead).all()
    errors = (found.gain / sensor.gain - 1)[found.known]
    assert np.median(np.abs(errors)) < 0.03
    assert (np.abs(errors) < 4 * found.gain_error[found.known]).all()
    assert abs(found.fit.thickness - sensor.thickness) < 4 * found.fit.thickness_error < 0.08 * sensor.thickness
    places = np.stack([loads.x, loads.y], axis=1)
    assert np.abs(found.fit.place - places).max() < 0.3 * sensor.nominal.pitch_x
    assert found.shown == pytest.approx(np.ones(34), abs=0.05)


@pytest.mark.parametrize("seed", range(SEED, SEED + 3))
def test_other_arrays(seed: int) -> None:
    numbers = measured(seed + 1)
    assert numbers["right"]
    assert numbers["dead"]
    assert numbers["gain"] < 0.03
    assert abs(numbers["thickness"]) < 0.05


@pytest.mark.long
def test_intervals_hold_the_truth() -> None:
    every = [measured(seed) for seed in range(5000, 5060)]
    assert all(each["right"] for each in every)
    inside = sum(each["gain_inside"] for each in every) / sum(each["told"] for each in every)
    assert 0.93 < inside < 0.98
    assert sum(each["thickness_inside"] for each in every) >= 51  # of 60: 57 are expected
    assert np.median([each["gain"] for each in every]) < 0.02
    assert np.median(np.abs([each["thickness"] for each in every])) < 0.03


def test_every_wrong_key_is_told_with_the_right_one(day: tuple[Sensor, Loads, Day]) -> None:
    sensor, loads, recorded = day
    way = sensor.given
    told = list(doubts(run(sensor, loads, recorded, replace(given(sensor), compression="negative"))))
    assert '[input]: compression = "positive" is needed: the loads show that sign' in told
    keys = f'order = "{way.order}", flip_x = {str(way.flip_x).lower()}, flip_y = {str(way.flip_y).lower()} is needed'
    assert any(keys in line for line in told)
    assert any("thickness_mm" in line for line in told) == (abs(sensor.thickness / NOMINAL.thickness - 1) > 0.03)
    right = list(doubts(run(sensor, loads, recorded, replace(way, pa_per_code=sensor.pascals))))
    assert not any("[input]" in line for line in right)


def test_an_array_at_rest_only(day: tuple[Sensor, Loads, Day], tmp_path: Path) -> None:
    sensor, loads, recorded = day
    with pytest.raises(InputError, match="force_n: at least one load with a normal force is needed"):
        run(sensor, loads, changed(recorded, tmp_path, lambda rows: rows[:1]))


@pytest.mark.parametrize(("unit", "factor"), [("g", 101.97), ("kg", 0.10197), ("mN", 1000.0)])
def test_forces_in_another_unit(day: tuple[Sensor, Loads, Day], tmp_path: Path, unit: str, factor: float) -> None:
    def wrong(rows: list[dict[str, str]]) -> list[dict[str, str]]:
        keys = ("force_n", "tangential_n")
        return [row | {key: str(float(row[key]) * factor) for key in keys if row[key]} for row in rows]

    sensor, loads, recorded = day
    with pytest.raises(InputError, match=f"force_n: all loads show .* times their forces: are those in {unit}?"):
        run(sensor, loads, changed(recorded, tmp_path, wrong))


def test_exchanged_recordings(day: tuple[Sensor, Loads, Day], tmp_path: Path) -> None:
    sensor, loads, recorded = day
    force = -loads.force[:30, 2]
    low, high = int(force.argmin()), int(force.argmax())

    def exchanged(rows: list[dict[str, str]]) -> list[dict[str, str]]:
        rows[low + 1]["recording"], rows[high + 1]["recording"] = f"load{high}", f"load{low}"
        return rows

    told = list(doubts(run(sensor, loads, changed(recorded, tmp_path, exchanged))))
    assert any(f"load{high}" in line and f"was it exchanged with load{low}?" in line for line in told)


def test_a_load_that_is_not_seen_is_left_out(day: tuple[Sensor, Loads, Day], tmp_path: Path) -> None:
    sensor, loads, recorded = day
    still = tmp_path / recorded.files[7].name
    np.save(still, np.tile(np.load(recorded.files[0]), (1, 1)))
    files = [*recorded.files[:7], still, *recorded.files[8:]]
    found = run(sensor, loads, replace(recorded, files=files))
    assert len(found.loads) == 33
    assert any("load6.npy: shows no load" in line and line.endswith("; left out") for line in doubts(found))
    with pytest.raises(InputError, match="shows no load"):
        run(sensor, loads, changed(replace(recorded, files=files), tmp_path, lambda rows: [rows[0], rows[7]]))


def test_few_loads(day: tuple[Sensor, Loads, Day], tmp_path: Path) -> None:
    sensor, loads, recorded = day
    one = run(sensor, loads, changed(recorded, tmp_path, lambda rows: rows[:2]))
    assert any(line.startswith("1 press tells of ") for line in doubts(one))
    assert any("no load tells how the array lies" in line for line in doubts(one))
    assert "direction_deg" in advice(one)


def test_presses_in_a_corner(tmp_path: Path) -> None:
    sensor = Sensor(NOMINAL, np.random.default_rng(5))
    loads = sensor.loads(8, 0)
    corner = replace(loads, x=3e-3 + loads.x / 6, y=3e-3 + loads.y / 8, radius=0.7 * loads.radius)
    found = run(sensor, corner, sensor.day(tmp_path, corner))
    assert any("taxels only, from " in line and "press elsewhere, too" in line for line in doubts(found))


def test_a_load_beyond_the_range(day: tuple[Sensor, Loads, Day], tmp_path: Path) -> None:
    sensor, loads, recorded = day
    at = int(np.argmax(-loads.force[:30, 2]))
    levels = np.load(recorded.files[at + 1])
    full = tmp_path / "full.npy"
    np.save(full, np.minimum(4095, 4 * levels.astype(np.int64)).astype(np.int16))
    files = [*recorded.files[:20], full]

    def more(rows: list[dict[str, str]]) -> list[dict[str, str]]:
        return [*rows[:20], {**rows[at + 1], "recording": "full"}]

    other = changed(replace(recorded, files=files), tmp_path, more)
    assert any("at an end of the converter's range under full" in line for line in doubts(run(sensor, loads, other)))


def test_advice_names_the_press_that_tells_most(found: Calibrated) -> None:
    force, (x, y), before, after = best_press(found)
    assert force == pytest.approx(max(load.normal for load in found.loads))
    assert after < before
    column, row = round(x / NOMINAL.pitch_x), round(y / NOMINAL.pitch_y)
    near = found.gain_error[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2]
    assert near.max() > np.median(found.gain_error)


def test_files_are_read_back(found: Calibrated, tmp_path: Path) -> None:
    write(found, tmp_path)
    read = read_calibration(tmp_path / "cal.toml", NOMINAL, found.given)
    np.testing.assert_allclose(read.gain, found.gain, rtol=1e-5)
    assert (read.dead == found.dead).all()
    assert read.cover is not None
    assert read.cover.thickness_mm == pytest.approx(1e3 * found.fit.thickness, rel=1e-5)
    tables = json.loads((tmp_path / "front_end.json").read_text())
    assert tables["settings"] == {"word_bits": 12, "is_unsigned": True, "invert": True}
    assert len(tables["gains"]) == len(tables["offsets"]) == NOMINAL.taxels
    assert {int(taxel) for taxel in tables["repairs"]} == set(np.flatnonzero(found.dead).tolist())
    turned = replace(found.given, flip_x=not found.given.flip_x)
    with pytest.raises(InputError, match=r"cal\.toml: flip_x: its tables are for flip_x"):
        read_calibration(tmp_path / "cal.toml", NOMINAL, turned)


def test_a_recording_that_starts_under_its_load(day: tuple[Sensor, Loads, Day], tmp_path: Path) -> None:
    sensor, loads, recorded = day
    turned = tmp_path / recorded.files[5].name
    np.save(turned, np.load(recorded.files[5])[50:])
    files = [*recorded.files[:5], turned, *recorded.files[6:]]
    with pytest.raises(InputError, match="go another way under the load than those of most"):
        run(sensor, loads, replace(recorded, files=files))
