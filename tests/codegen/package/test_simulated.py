"""Both drivers with a simulated device: the same scenario, and planted faults that it must notice."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.codegen.cocotb_run import outcome
from tests.codegen.package.device import device
from tests.marks import long
from tfra.codegen.package.drivers import driver_files
from tfra.codegen.registers.files import register_files
from tfra.codegen.registers.values import parameters
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.wrapper import wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.choices import SERIAL, Architecture, Bus
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status

DESIGN = TfraDesign(SensorArray(3, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4), images="load")


def frames(design: Design) -> Ints:
    """Codes of four frames ``(4, taxels)``, of which nothing saturates: a front end would report it as a fault."""
    most = 1 << design.adc.bits - 2
    codes = np.random.default_rng(1).integers(-most, most, (64, design.sensor.taxels))
    saturated = design.model(codes).words[:, -1] & (Status.INPUT_SATURATED | Status.OUTPUT_SATURATED)
    return codes[saturated == 0][:4]


@pytest.fixture(scope="module")
def package() -> dict[str, str]:
    """Drivers, registers, and the device."""
    return {**register_files(DESIGN), **driver_files(DESIGN), **device(DESIGN, DESIGN.model(frames(DESIGN)).words)}


def simulated(
    simulator: str, folder: Path, design: Design, texts: Mapping[str, str], driver: str, top: str, *sources: str
) -> str:
    """Play the scenario with a ``driver`` of the package ``texts`` and its ``sources``, whose module is ``top``.

    Returns what went wrong.
    """
    loaded, codes = microarchitecture(design).loaded, frames(design)
    world: dict[str, Any] = {"name": design.name, "driver": driver}
    world |= {"sidecar": sidecar(design), "frames": codes.tolist()}
    world |= {"taxels_per_beat": parameters(design)["TAXELS_PER_BEAT"]}
    world |= {"coefficients": [] if loaded is None else loaded.ravel().tolist()}
    world |= {"results": design.model(codes).words.tolist()}
    for name, text in {**texts, "world.json": json.dumps(world)}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return str(outcome("tests.codegen.package.bridge", simulator, folder, top, *sources))


@pytest.mark.parametrize(("simulator", "driver"), [("icarus", "c"), *long(("icarus", "python"), ("verilator", "c"))])
def test_the_scenario(tmp_path: Path, package: dict[str, str], simulator: str, driver: str) -> None:
    assert simulated(simulator, tmp_path, DESIGN, package, driver, "device", "device.v") == ""


@pytest.mark.parametrize(
    ("simulator", "driver", "change"),
    [
        ("icarus", "c", {}),
        ("icarus", "python", {}),
        ("verilator", "c", {"images": "inline", "bus": Bus(4)}),
        ("verilator", "python", {"architecture": SERIAL, "images": "inline", "bus": Bus(2)}),
    ],
)
@pytest.mark.long
def test_the_scenario_on_the_core(tmp_path: Path, simulator: str, driver: str, change: dict[str, Any]) -> None:
    """The generated wrapper and core in place of the device."""
    design = replace(DESIGN, name="skin", **change)
    texts = {**register_files(design), **driver_files(design)}
    texts |= {"skin_axi.v": wrapper_verilog(design), "skin.v": to_verilog(design)}
    assert simulated(simulator, tmp_path, design, texts, driver, "skin_axi", "skin_axi.v", "skin.v") == ""


PLANTED = [
    ("c", "driver/tfra_driver.c", "0xEDB88320u", "0xEDB88330u", "another checksum"),
    ("python", "python/tfra_host/constants.json", '"address": 104', '"address": 100', "frames_dropped"),
    ("c", "registers/tfra.h", "CHECKSUM;\n    uint32_t LOAD_CRC;", "CRC;\n    uint32_t LOAD_CHECKSUM;", "SlaveError"),
    ("c", "driver/tfra_driver.c", "(word & OPTIONS) | bits", "(word & 0u) | bits", "a stop keeps the options"),
    ("c", "registers/tfra.h", "__DEAD_BAND_bp 0", "__DEAD_BAND_bp 1", "set_front_end"),
    ("c", "driver/tfra_driver.c", "PUT(table, CALIBRATION_PLACE, KIND)", "(table & 0u)", "get_gains"),
    ("python", "python/tfra_host/registers.py", "zlib.crc32(", "zlib.adler32(", "another checksum"),
]


@pytest.mark.long
@pytest.mark.parametrize(("driver", "name", "stated", "other", "seen"), PLANTED)
def test_a_planted_fault_is_noticed(
    tmp_path: Path, package: dict[str, str], driver: str, name: str, stated: str, other: str, seen: str
) -> None:
    assert package[name].count(stated) == 1
    texts = {**package, name: package[name].replace(stated, other)}
    assert seen in simulated("icarus", tmp_path, DESIGN, texts, driver, "device", "device.v")


@pytest.mark.long
def test_a_wrong_result_is_noticed(tmp_path: Path, package: dict[str, str]) -> None:
    words = DESIGN.model(frames(DESIGN)).words
    words[1, 4] ^= 1
    texts = {**package, **device(DESIGN, words)}
    error = simulated("icarus", tmp_path, DESIGN, texts, "python", "device", "device.v")
    assert "dict(frame.words) == expected" in error
