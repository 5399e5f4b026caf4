"""Both drivers with a simulated core: the same scenario, and planted faults that it must notice."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.codegen.cocotb_run import outcome
from tests.codegen.package.made import write
from tests.marks import long
from tfra.codegen.package.drivers import driver_files
from tfra.codegen.registers.files import register_files
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.wrapper import module_name, wrapper_verilog
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


def texts_of(design: Design) -> dict[str, str]:
    """Drivers, registers, the wrapper and the core."""
    verilog = {"axi.v": wrapper_verilog(design), "core.v": to_verilog(design)}
    return {**register_files(design), **driver_files(design), **verilog}


@pytest.fixture(scope="module")
def package() -> dict[str, str]:
    return texts_of(DESIGN)


def simulated(
    simulator: str, driver: str, folder: Path, design: Design, texts: Mapping[str, str], wrong: int = 0
) -> str:
    """Play the scenario with a ``driver`` of the package ``texts``; returns what went wrong.

    The bits ``wrong`` of a word of the expected results are flipped.
    """
    loaded, codes = microarchitecture(design).loaded, frames(design)
    words = design.model(codes).words
    words[1, 4] ^= wrong
    world = {
        "name": design.name,
        "driver": driver,
        "sidecar": sidecar(design),
        "frames": codes.tolist(),
        "taxels_per_beat": design.bus.taxels_per_beat,
        "coefficients": [] if loaded is None else loaded.ravel().tolist(),
        "results": words.tolist(),
    }
    write(folder, {**texts, "world.json": json.dumps(world)})
    top = module_name(design)
    return str(outcome("tests.codegen.package.bridge", simulator, folder, top, "axi.v", "core.v"))


@pytest.mark.parametrize(
    ("simulator", "driver", "change"),
    [
        *long(
            ("icarus", "c", {}),
            ("icarus", "python", {"architecture": SERIAL, "images": "inline", "bus": Bus(2)}),
        ),
    ],
)
def test_the_scenario(
    tmp_path: Path, package: dict[str, str], simulator: str, driver: str, change: dict[str, Any]
) -> None:
    design = replace(DESIGN, **change)
    assert simulated(simulator, driver, tmp_path, design, texts_of(design) if change else package) == ""


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
    assert seen in simulated("icarus", driver, tmp_path, DESIGN, texts)


@pytest.mark.long
def test_a_wrong_result_is_noticed(tmp_path: Path, package: dict[str, str]) -> None:
    assert "dict(frame.words) == expected" in simulated("icarus", "python", tmp_path, DESIGN, package, wrong=1)
