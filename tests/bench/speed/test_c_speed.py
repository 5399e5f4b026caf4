"""The C programs give the float model's results, and whatever differs is noticed."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from bench.speed import c_program, c_speed
from bench.speed.c_program import Library, Program
from bench.speed.c_speed import EXACT, compare
from tests.marks import long
from tfra.model.choices import Adc, Architecture
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status, Tfra

FLAGS = [
    ("-O3", "-march=native"),
    *long((("-O3", "-Wextra", "-Werror"),), (("-O0",),)),
]
"""How the program is built: the first as it is measured."""

SENSORS = {
    "10x10": SensorArray(10, 10, 4e-3, 2e-3, 3e-3),
    "2x2": SensorArray(2, 2, 4e-3, 2e-3, 3e-3),
    "12x14": SensorArray(12, 14, 2e-3, 3e-3, 3e-3),
}
SCENES = [("10x10", 100), ("2x2", 1), ("12x14", 1), *long(("10x10", 1), ("2x2", 100), ("12x14", 100))]
"""Sensors and steps."""

FOLDED = Program("tfra", "double")
THRESHOLD = Adc().threshold * Adc().lsb


def scene(sensor, steps=100, count=100):
    """Frames in Pa and the float model's results."""
    design = TfraDesign(sensor, architecture=Architecture(4))
    stress = np.concatenate([contact_codes(design, count, 5), wild_codes(design, count, 6)]) * design.adc.lsb
    return stress, Tfra(sensor, steps, contact_threshold=THRESHOLD)(stress)


def library(program, sensor, directory, steps=100):
    """``program`` with the threshold of the scenes."""
    return Library(program, sensor, steps, directory, THRESHOLD)


@pytest.mark.parametrize("flags", FLAGS, ids=" ".join)
@pytest.mark.parametrize(("name", "steps"), SCENES)
def test_doubles_equal_the_float_model(name, steps, flags, tmp_path):
    stress, expected = scene(SENSORS[name], steps)
    found, times = library(replace(FOLDED, flags=flags), SENSORS[name], tmp_path, steps)(stress)
    indices, states, worst = compare(found, expected)
    assert (indices, states) == (0, 0)
    assert worst < EXACT
    assert times.shape == (len(stress),)
    assert (times > 0).all()


def test_frames_of_every_status(tmp_path):
    design = TfraDesign(SENSORS["10x10"])
    stress = directed_codes(design) * design.adc.lsb
    expected = Tfra.of(design)(stress)
    for flag in (Status.NO_CONTACT, Status.COMPRESSION_ONLY, Status.NO_DIRECTION):
        assert (expected.status & flag).any()
    found, _ = library(FOLDED, design.sensor, tmp_path)(stress)
    np.testing.assert_array_equal(found.status, expected.status)
    decided = found.sweep_index == expected.sweep_index  # ties of symmetric frames are left to rounding
    assert decided.mean() > 0.8
    chosen = [Result(**{n: v[decided] for n, v in vars(r).items() if v is not None}) for r in (found, expected)]
    assert compare(*chosen)[2] < EXACT


def test_single_precision_is_close(tmp_path):
    stress, expected = scene(SENSORS["10x10"], count=300)
    found, _ = library(Program("tfra", "float"), SENSORS["10x10"], tmp_path)(stress)
    assert found.forces.dtype == np.float32
    indices, states, worst = compare(found, expected)
    assert indices < 0.02 * len(stress)
    assert states < 0.02 * len(stress)
    assert 1e-9 < worst < 1e-2


@pytest.mark.parametrize("flags", FLAGS[:2], ids=" ".join)
def test_the_literal_loop_agrees(flags, tmp_path):
    program = Program("literal", "double", flags)
    stress, expected = scene(SENSORS["10x10"])
    found, _ = library(program, SENSORS["10x10"], tmp_path)(stress)
    indices, states, worst = compare(found, expected)
    assert indices <= 1
    assert states <= 1
    assert worst < EXACT


@pytest.mark.parametrize("threshold", [1, *long(0, 64)])
@pytest.mark.parametrize(("source", "real"), [("tfra", "double"), ("tfra", "float"), ("literal", "double")])
def test_the_contact_threshold_is_exact(source, real, threshold, tmp_path):
    design = TfraDesign(SENSORS["10x10"], adc=Adc(full_scale=70.1e3, contact_threshold=threshold))
    noise = np.random.default_rng(3).integers(-threshold, max(1, threshold), (4, 10, 10))
    noise[:, 0, 0], noise[:, 5, 5] = -1, (-threshold - 1, -threshold, threshold - 1, threshold)
    expected = [0, 1, 1, 0] if threshold else [0, 0, 0, 0]
    program, stress = Program(source, real), noise * design.adc.lsb
    found, _ = Library(program, design.sensor, 100, tmp_path, threshold * design.adc.lsb)(stress)
    assert (found.status & Status.NO_CONTACT).tolist() == expected
    quiet = found.status == Status.NO_CONTACT
    for values in vars(found).values():
        assert values is None or values is found.status or not values[quiet].any()


@pytest.mark.parametrize("name", ["forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status"])
def test_one_wrong_value_is_noticed(name):
    _, expected = scene(SENSORS["10x10"], count=5)
    assert compare(expected, expected) == (0, 0, 0.0)
    wrong = getattr(expected, name).copy()
    wrong.flat[-1] += 1 if wrong.dtype.kind == "i" else 1e-3
    indices, states, worst = compare(replace(expected, **{name: wrong}), expected)
    assert indices + states == (name in ("sweep_index", "status"))
    assert (worst > EXACT) == (name not in ("sweep_index", "status"))
    if name not in ("sweep_index", "status"):
        wrong.flat[-1] = np.nan
        assert compare(replace(expected, **{name: wrong}), expected)[2] == np.inf


@pytest.mark.parametrize(("table", "factor"), [("PINV3", 1.000001), ("NORMAL", 2)])
def test_one_wrong_coefficient_stops_the_measurement(table, factor, tmp_path, monkeypatch):
    good = c_program.folded_tables

    def bad(sensor):
        tables = good(sensor)
        tables[table][0, 3, 3] *= factor
        return tables

    monkeypatch.setattr(c_program, "folded_tables", bad)
    stress, expected = scene(SENSORS["10x10"], count=20)
    with pytest.raises(ValueError, match="differ from the float model"):
        c_speed.examine(c_speed.Tally(), FOLDED, library(FOLDED, SENSORS["10x10"], tmp_path), stress, expected)


def test_what_can_not_be_compiled(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="rows, columns: even numbers are needed, got 5, 7"):
        Library(FOLDED, SensorArray(5, 7, 4e-3, 2e-3, 3e-3), 100, tmp_path)
    with pytest.raises(ValueError, match=r"cc failed: .*-fno-such-thing"):
        Library(replace(FOLDED, flags=("-fno-such-thing",)), SENSORS["2x2"], 100, tmp_path)
    monkeypatch.setattr(c_program.shutil, "which", lambda name: None)
    with pytest.raises(ValueError, match="cc is missing, please run: apt-get install gcc libc6-dev"):
        Library(FOLDED, SENSORS["2x2"], 100, tmp_path)


def test_the_table_has_programs_cores_and_what_was_published(tmp_path, monkeypatch):
    monkeypatch.setattr(c_speed, "ROOT", tmp_path)
    assert c_speed.fpga_rows() == []
    times = {"frame_latency_us": 12.5, "interval_us": 8.0}
    fast = {"name": "fast", "target": "ecp5-45-6", "clock": {"median_mhz": 80.04}, "timing": times}
    slow = {**fast, "name": "slow", "target": "ice40up5k", "timing": {**times, "frame_latency_us": 100.0}}
    results = tmp_path / "bench" / "results"
    results.mkdir(parents=True)
    (results / "presets.json").write_text(json.dumps({"slow": slow, "fast": fast}))
    names = ["core `fast` on ecp5-45-6, 80.0 MHz", "core `slow` on ice40up5k, 80.0 MHz"]
    assert c_speed.fpga_rows() == [(names[0], 12.5, 8.0), (names[1], 100.0, 8.0)]
    monkeypatch.setattr(c_speed, "LITERAL_SHARE", 1)
    record = c_speed.measure(40, batch=20)
    assert {row["compared"] for row in record["rows"].values()} == {40}
    assert json.loads(json.dumps(record))["rows"].keys() == c_speed.PROGRAMS.keys()
    lines = c_speed.table(record).splitlines()
    for name, row in record["rows"].items():
        assert 0 < row["timed"] < 40
        assert row["steady_us"] <= row["max_us"]
        assert row["median_us"] <= row["p999_us"] <= row["max_us"]
        assert any(line.startswith(f"| {name} |") for line in lines)
    (core,) = (line for line in lines if line.startswith("| core `fast`"))
    assert core == f"| {names[0]}, one every 8.0 µs | 12.5 | 12.5 | 12.5 | 12.5 | – | 4,694 | 2,582 |"
    assert len({line.count("|") for line in lines if line.startswith("|")}) == 1
