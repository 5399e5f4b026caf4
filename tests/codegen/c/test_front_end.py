"""The front end in C against the model's, frame by frame, with settings that change between them."""

import ctypes
import subprocess
from ctypes import byref, c_int16, c_int32, c_uint8, c_uint16, c_uint32
from dataclasses import fields

import numpy as np
import pytest

from tests.codegen.package.made import write
from tests.hdl.parallel.designs import make
from tests.marks import long
from tfra.codegen.c.files import files
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import FAULTS, FrontEnd, Settings, Tables
from tfra.model.fixed.repair import HEADER, PLACE

FLAGS = (*FAULTS, "sequence_gap")
BYTES = ("word_bits", "is_unsigned", "invert", "log2_average", "log2_tare", "stuck_frames", "check_sequence")


def structure(taxels: int) -> type[ctypes.Structure]:
    """``NAME_front_end`` of the header."""
    names = [(name, c_uint8) for name in BYTES] + [("dead_band", c_uint16), ("contact", c_uint16)]
    names += [("offsets", c_int32 * taxels), ("gains", c_uint32 * taxels), ("repairs", ctypes.POINTER(c_uint32))]
    private = [
        ("sums", c_int32 * taxels),
        ("words", c_uint16 * taxels),
        ("ages", c_uint8 * taxels),
        ("number", c_uint16),
    ]
    private += [(name, c_uint8) for name in ("seen", "numbered", "taring", "averaged")]
    return type("FrontEnd", (ctypes.Structure,), {"_fields_": [*names, ("repair_words", c_uint16), *private]})


@pytest.fixture(scope="module", params=[8, 12, 16])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Design, ctypes.CDLL]:
    """A design for words of so many bits, and its library."""
    design, folder = make(3, 4, bits=request.param), tmp_path_factory.mktemp("core")
    write(folder, files(design))
    command = ["gcc", "-O1", "-shared", "-fPIC", "-o", "core.so", f"{design.name}.c", f"{design.name}_tables.c"]
    subprocess.run(command, cwd=folder, check=True)
    return design, ctypes.CDLL(str(folder / "core.so"))


def settings(rng: np.random.Generator) -> Settings:
    least = int(rng.integers(8, 17))
    return Settings(
        least,
        *(bool(bit) for bit in rng.integers(0, 2, 2)),
        log2_average=int(rng.integers(0, 4)),
        log2_tare=int(rng.integers(0, 4)),
        dead_band=int(rng.choice([0, 5, 300])),
        contact=int(rng.choice([0, 40])),
        stuck_frames=int(rng.choice([0, 2, 5])),
        check_sequence=bool(rng.integers(0, 2)),
    )


def tables(rng: np.random.Generator, taxels: int) -> Tables:
    """Random ones; a taxel may be silent, and the table of repairs may begin with words that do nothing."""
    gains = np.where(rng.random(taxels) < 0.2, 0, rng.integers(0, 1 << 17, taxels))
    repairs = rng.integers(0, taxels, 12) << PLACE | rng.integers(0, 1 << PLACE, 12)
    repairs[rng.random(12) < 0.3] |= HEADER
    return Tables(rng.integers(-1 << 17, 1 << 17, taxels), gains, repairs)


@pytest.mark.parametrize("seed", [0, 1, *long(*range(2, 8))])
def test_codes_and_faults(made: tuple[Design, ctypes.CDLL], seed: int) -> None:
    (design, library), rng = made, np.random.default_rng(seed)
    taxels, name = design.sensor.taxels, design.name
    unit = structure(taxels)()
    step = getattr(library, f"{name}_front_end_step")
    getattr(library, f"{name}_front_end_init")(byref(unit))
    model = FrontEnd(design)
    assert (list(unit.offsets), list(unit.gains)) == (model.tables.offsets.tolist(), model.tables.gains.tolist())
    codes, faults = (c_int16 * taxels)(), c_uint8()
    number, word = 0, rng.integers(0, 1 << 16, taxels)
    for frame in range(400):
        if frame % 40 == 20:
            model.settings, model.tables = settings(rng), tables(rng, taxels)
            kept = _take(unit, model.settings, model.tables)
        if frame % 80 == 60:
            model.tare()
            getattr(library, f"{name}_front_end_tare")(byref(unit))
        word = np.where(rng.random(taxels) < 0.5, word, _words(rng, model.settings, taxels))
        number += int(rng.choice([1, 1, 1, 2]))
        given = model(word, np.array([number]))
        ready = step(byref(unit), (c_uint16 * taxels)(*word.tolist()), c_uint16(number & 0xFFFF), codes, byref(faults))
        assert ready == len(given.codes), f"seed {seed}, frame {frame}"
        assert list(unit.offsets) == model.tables.offsets.tolist()
        if ready:
            assert list(codes) == given.codes.ravel().tolist(), f"seed {seed}, frame {frame}"
            flags = sum(1 << bit for bit, flag in enumerate(FLAGS) if given.flags[flag][0])
            assert faults.value == flags, f"seed {seed}, frame {frame}"
    del kept


def _take(unit: ctypes.Structure, chosen: Settings, given: Tables) -> ctypes.Array[c_uint32]:
    """Copy settings and tables; the table of repairs has to stay."""
    for each in fields(chosen):
        setattr(unit, each.name, int(getattr(chosen, each.name)))
    unit.offsets[:], unit.gains[:] = given.offsets.tolist(), given.gains.tolist()
    repairs = (c_uint32 * len(given.repairs))(*given.repairs.tolist())
    unit.repairs, unit.repair_words = repairs, len(repairs)
    return repairs


def _words(rng: np.random.Generator, chosen: Settings, taxels: int) -> Ints:
    """Words at the ends of the range, small ones, and ones out of it."""
    half = 1 << (chosen.word_bits - 1)
    small = rng.integers(-half // 64, half // 64 + 1, taxels) & 0xFFFF
    return np.choose(
        rng.integers(0, 4, taxels),
        [small, small, (half + rng.integers(-1, 1, taxels)) & 0xFFFF, rng.integers(0, 1 << 16, taxels)],
    )
