"""The drivers without a simulator: compilers, sanitizers, frames, checksums, a bus that fails."""

import ast
import ctypes
import json
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.codegen.package.c_driver import SOURCES, STRICT, CCore, compiled
from tests.codegen.package.made import write
from tests.codegen.package.test_simulated import DESIGN, frames
from tests.hdl.bus.model import Model
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design
from tfra.calibrate.files import as_json, header
from tfra.codegen.package.drivers import HEADER, driver_files
from tfra.codegen.registers.files import register_files
from tfra.codegen.registers.source import parameters, register_map
from tfra.codegen.sidecar.build import sidecar
from tfra.hdl.bus.map import RegisterMap
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.framer import FAULTS
from tfra.model.fixed import front_end
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray
from tfra.model.skin.skin import Skin

MAP = register_map(parameters(DESIGN))
FACTS, WORDS = sidecar(DESIGN), DESIGN.model(frames(DESIGN)).words
LEARNED = learned_design(2, 3)
NO_FORCES = replace(LEARNED, taxel_forces=False)
COMPILERS = ["gcc", *(["clang"] if shutil.which("clang") else [])]


def written(folder: Path, design: Design | Skin) -> Path:
    """The package of ``design`` in ``folder``."""
    texts = {**register_files(design), **driver_files(design), f"{design.name}.json": json.dumps(sidecar(design))}
    write(folder, texts)
    return folder


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("package"), DESIGN)


@pytest.fixture(scope="module")
def host(package: Path) -> ModuleType:
    return imported(package)


def imported(folder: Path) -> ModuleType:
    """The Python driver of the package in ``folder``."""
    for name in [name for name in sys.modules if name.split(".")[0] == "tfra_host"]:
        del sys.modules[name]
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder / "python")
        return import_module("tfra_host")


@pytest.fixture(scope="module")
def library(package: Path) -> ctypes.CDLL:
    return compiled(package, DESIGN.name)


@pytest.mark.long
def test_the_driver_is_the_same_for_every_design() -> None:
    other = driver_files(replace(DESIGN, sensor=SensorArray(2, 4, 4e-3, 4e-3, 3e-3)))
    differ = {name for name, text in driver_files(DESIGN).items() if other[name] != text}
    own = {f"driver/tfra_{kind}.h" for kind in ("config", "coefficients", "recorded")}
    assert differ == {*own, "python/tfra_host/constants.json"}


def test_compilers_have_no_complaint(package: Path, tmp_path: Path) -> None:
    """Of all files in C, and of the headers in C++."""
    folders = [f"-I{package}/driver", f"-I{package}/registers", "-fsyntax-only"]
    for compiler in COMPILERS:
        for file in (*SOURCES, "example.c"):
            subprocess.run([compiler, *STRICT, "-O2", *folders, package / "driver" / file], check=True)
    (tmp_path / "all.cpp").write_text('#include "tfra_config.h"\n#include "tfra_units.h"\n')
    options = ["-Wall", "-Wextra", "-Wno-unused-variable", "-Werror"]
    subprocess.run(["g++", *options, *folders, tmp_path / "all.cpp"], check=True)


def test_nothing_needs_floating_point_or_a_heap(package: Path, tmp_path: Path) -> None:
    """The device part has no undefined names but its own, and computes with integers alone."""
    for file in SOURCES:
        command = ["gcc", "-std=c99", "-O2", "-ffreestanding", "-mgeneral-regs-only", "-c", package / "driver" / file]
        folders = [f"-I{package}/driver", f"-I{package}/registers"]
        subprocess.run([*command, *folders, "-o", tmp_path / "out.o"], check=True)
        done = subprocess.run(["nm", "-u", tmp_path / "out.o"], capture_output=True, text=True, check=True)
        assert set(done.stdout.split()) <= {"U", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}


def test_python_3_9_is_enough(package: Path) -> None:
    """Its syntax, and no module that is not of Python itself."""
    for file in (package / "python").rglob("*.py"):
        tree = ast.parse(file.read_text(), feature_version=(3, 9))
        absolute = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level]
        roots = {(node.module or "").split(".")[0] for node in absolute}
        roots |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
        assert roots <= set(sys.stdlib_module_names) | {"tfra_host"}, file


def test_the_coefficients(package: Path, host: ModuleType) -> None:
    loaded = microarchitecture(DESIGN).loaded
    assert loaded is not None
    text = (package / "driver" / "tfra_coefficients.h").read_text().partition("{")[2].partition("}")[0]
    assert [int(word) for word in text.split(",") if word.strip()] == loaded.tolist()
    (package / "load.hex").write_text("".join(f"{int(word) & 0x3FFFF:05x}\n" for word in loaded))
    assert host.read_coefficients(package / "load.hex", FACTS) == loaded.tolist()


def beats(design: Design, words: list[int], forces: bool = True, header: tuple[int, int] = (0, 1 << 24)) -> list[int]:
    """An output frame, made as the specification says."""
    found = list(header)
    for field in design.layout:
        if forces or field.name != "forces":
            found += [word & 0xFFFFFFFF for word in words[field.start : field.start + field.count]]
    return found


def c_program(folder: Path, array: Design | Skin, name: str = "frames") -> Path:
    """``frames.c`` or ``contacts.c`` with sanitizers, for the package in ``folder``."""
    source = folder / f"{name}.c"
    source.write_text(Path(__file__).with_name(f"{name}.c").read_text().replace("DESIGN", array.name))
    options = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    options += [f"-I{folder}/driver", f"-I{folder}/registers", "-o", str(folder / name)]
    subprocess.run(["gcc", *STRICT, *options, source, folder / "driver" / "tfra_frame.c"], check=True)
    return folder / name


def answers(program: Path, sent: list[list[int]]) -> list[list[str]]:
    """What ``frames.c`` prints for frames."""
    text = "\n".join(f"{len(words):x} " + " ".join(f"{word:x}" for word in words) for words in sent)
    done = subprocess.run([program], input=text, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return [line.split() for line in done.stdout.splitlines()]


@pytest.mark.parametrize("design", [DESIGN, LEARNED, *long(NO_FORCES)], ids=["tfra", "learned", "no forces"])
def test_frames(tmp_path: Path, design: Design) -> None:
    """Integers and units of C and of Python are those of the model's words and the layout's LSBs."""
    folder = written(tmp_path, design)
    host, program, facts = imported(folder), c_program(folder, design), sidecar(design)
    most = 1 << design.adc.bits - 2
    codes = np.random.default_rng(2).integers(-most, most, (8, design.sensor.taxels))
    taken = [(words, forces) for words in design.model(codes).words.tolist() for forces in (True, False)]
    sent = [beats(design, w, forces, (0xFFFF0000 | n, 0x010003A4)) for n, (w, forces) in enumerate(taken)]
    lines = answers(program, sent)
    for number, ((words, forces), frame, line) in enumerate(zip(taken, sent, lines, strict=True)):
        field = {f.name: words[f.start : f.start + f.count] for f in design.layout if forces or f.name != "forces"}
        parsed = host.parse_frame(facts, struct.pack(f"<{len(frame)}I", *frame))
        assert {name: list(found) for name, found in parsed.words.items()} == field
        faults = {"saturation", "sequence_gap", "simulated", "out_of_range", "stuck"}
        assert (parsed.sequence, parsed.user, parsed.faults) == (number, 0xFFFF, faults)
        names = ("frame", "exponent", "sweep_index", "phi", "mu", "mu_x", "mu_y", "uncertainty", "status")
        integers = [0, number, 0xFFFF, 0x3A4, *(field.get(name, [0])[0] for name in names)]
        assert [int(word) for word in line[:13]] == integers
        lsb, exponent = {f.name: f.lsb for f in design.layout}, field["exponent"][0]
        plain = [field[name][0] * lsb[name] for name in ("phi", "mu", "mu_x", "mu_y")]
        newton = {name: [word * lsb[name] / 2**exponent for word in field[name]] for name in field if name in lsb}
        expected = [*plain, *newton.get("uncertainty", [0.0]), *newton["resultant"], *newton.get("forces", [])]
        assert [float.fromhex(word) for word in line[13:]] == expected
        assert [parsed.phi_deg, parsed.mu, parsed.mu_x, parsed.mu_y] == plain
        assert parsed.uncertainty == newton.get("uncertainty", [None])[0]
        assert list(parsed.resultant) == newton["resultant"]
        planes = newton.get("forces")
        assert (parsed.forces is None) == (planes is None)
        assert planes is None or [force for plane in parsed.forces for force in plane] == planes
        assert parsed.status == {flag.name for flag in design.status_bits if field["status"][0] & flag}


WHOLE = beats(DESIGN, WORDS[0].tolist())
SHORT = len(beats(DESIGN, WORDS[0].tolist(), forces=False))
BAD = [
    *(([*WHOLE[:count], 0xFFFFFFFF], 13, "soft reset") for count in (1, SHORT - 1, len(WHOLE) - 1)),
    (WHOLE[:-1], 11, "bytes"),
    ([*WHOLE, 0], 11, "bytes"),
    ([], 11, "bytes"),
    ([WHOLE[0], 2 << 24, *WHOLE[2:]], 12, "format 2"),
    ([*WHOLE[:2], 1 << 16, *WHOLE[3:]], 12, "frame has more than 16 bits"),
    ([*WHOLE[:-2], 1 << 20, WHOLE[-1]], 12, "forces has more than 21 bits"),
    ([*WHOLE[:-2], 0xFFEFFFFF, WHOLE[-1]], 12, "forces has more than 21 bits"),
]


def test_bad_frames(package: Path, host: ModuleType) -> None:
    lines = answers(c_program(package, DESIGN), [words for words, *_ in BAD])
    assert [int(line[0]) for line in lines] == [code for *_, code, _ in BAD]
    for words, _, text in BAD:
        with pytest.raises(host.DeviceError, match=text):
            host.parse_frame(FACTS, struct.pack(f"<{len(words)}I", *words))


class Answers:
    """A bus with the registers' own behaviour, states as given, which fails at one of its accesses."""

    def __init__(self, states: dict[str, int], failing: int = -1, registers: RegisterMap = MAP) -> None:
        self._model, self._left = Model(registers), failing
        for path, value in states.items():
            self._model.values[path] = value
        self.written: list[tuple[int, int]] = []

    def read32(self, address: int) -> int:
        self._count()
        word, response = self._model.read(address)
        assert response == 0
        return word

    def write32(self, address: int, word: int) -> None:
        self._count()
        self.written.append((address, word))
        assert self._model.write(address, word) == 0

    def _count(self) -> None:
        self._left -= 1
        if self._left == -1:
            raise OSError("planted")


READY = {"STATUS.loaded": 1, "LOAD_STATUS.ready": 1, "LOAD_STATUS.match": 1}


def all_calls(core: Any, host: ModuleType) -> None:
    """Every function that accesses the core; none of them is refused with ``READY``."""
    core.load(microarchitecture(DESIGN).loaded.tolist()[:160])
    core.set_front_end(host.FrontEnd(12))
    core.set_repairs({})
    for name in ("get_load", "get_front_end", "get_counters", "get_errors", "get_faulty_taxel", "get_interrupts"):
        getattr(core, name)()
    core.get_offsets(0, 1)
    core.get_gains(0, 1)
    core.get_repairs()
    core.set_offsets(0, [])
    core.set_gains(0, [])
    core.set_options(["drop_late"])
    core.set_stale_timeout(1)
    for name in ("clear_counters", "clear_errors", "acknowledge_interrupts", "simulate_error", "wait_idle"):
        getattr(core, name)()
    core.enable_interrupts(["error"])
    core.tare(0)
    core.wait_tare()
    core.stop()
    core.soft_reset()
    core.start()


@pytest.fixture(params=["c", "python"])
def driven(request: pytest.FixtureRequest, host: ModuleType, library: ctypes.CDLL) -> Callable[[Answers], Any]:
    """The driver on a bus."""
    if request.param == "c":
        return lambda bus: CCore(library, host, bus, FACTS, 5)
    return lambda bus: host.Core(bus, FACTS, 5)


def test_every_failing_access_is_reported(driven: Callable[[Answers], Any], host: ModuleType) -> None:
    """Whichever access fails, the call that made it says so and makes no other."""
    bus = Answers(READY, 1 << 20)
    all_calls(driven(bus), host)
    total = (1 << 20) - bus._left
    assert total > 400
    for failing in [*range(20), *range(20, total - 80, 37), *range(total - 80, total)]:
        bus = Answers(READY, failing)
        with pytest.raises(OSError, match="planted"):
            all_calls(driven(bus), host)
        assert bus._left == -1


@pytest.mark.parametrize(
    ("states", "call", "text"),
    [
        ({"ID.text": 0}, "open", "no TFRA core"),
        ({"VERSION.map": 2}, "open", "register map"),
        ({"CONFIG_HASH_LOW.bits": 1}, "open", "another configuration"),
        ({"CONFIG_HASH_HIGH.bits": 1}, "open", "another configuration"),
        ({"LOAD_STATUS.ready": 0}, "load", "did not become"),
        ({"STATUS.loaded": 0}, "load", "did not become"),
        ({"LOAD_STATUS.match": 0}, "load", "coefficients arrived with another checksum"),
        ({"STATUS.running": 1}, "load", "stopped core"),
        ({"STATUS.running": 1}, "stop", "did not become"),
        ({"STATUS.busy": 1}, "wait_idle", "did not become"),
        ({"STATUS.taring": 1}, "wait_tare", "did not become"),
        ({"STATUS.loaded": 0}, "start", "no coefficients"),
        ({"CALIBRATION_CRC.crc": 1}, "set_gains", "arrived with another checksum"),
        ({"CONTROL.run": 1}, "set_gains", "stopped core"),
    ],
)
def test_refusals(
    states: dict[str, int], call: str, text: str, driven: Callable[[Answers], Any], host: ModuleType
) -> None:
    arguments = {"load": ([1] * 160,), "set_gains": (0, [])}.get(call, ())
    with pytest.raises(host.DeviceError, match=text):
        getattr(driven(Answers(READY | states)), call)(*arguments)


def test_repairs(host: ModuleType, library: ctypes.CDLL) -> None:
    """Literal words, the same in both languages."""
    repairs = {5: {0: 1.0, 3: -0.5}, 1: {5: 131071 / 65536}}
    words = [1 << 31 | 5 << 18, 65536, 3 << 18 | 0x38000, 1 << 31 | 1 << 18, 5 << 18 | 0x1FFFF]
    assert host.repair_words(repairs) == words
    with pytest.raises(ValueError, match="weight"):
        host.repair_words({0: {1: 2.0}})
    for core in (host.Core(bus := Answers(READY), FACTS), CCore(library, host, bus, FACTS, 5)):
        bus.written.clear()
        with pytest.raises(host.DeviceError, match="checksum"):  # this bus makes none
            core.set_repairs(repairs)
        assert [word for address, word in bus.written if address == 0xB8] == words


SHIM = """#include <stdio.h>
#include "front_end.h"

tfra_error_t tfra_get_front_end(tfra_device_t *device, tfra_front_end_t *settings)
{
    (void)device;
    *settings = (tfra_front_end_t){.word_bits = 16, .dead_band = 3};
    return TFRA_OK;
}

tfra_error_t tfra_set_front_end(tfra_device_t *device, const tfra_front_end_t *settings)
{
    (void)device;
    printf("%u %d %d %u\\n", settings->word_bits, settings->is_unsigned, settings->invert, settings->dead_band);
    return TFRA_OK;
}

#define TABLE(NAME, TYPE, FIRST)                                                         \\
    tfra_error_t NAME(tfra_device_t *device FIRST, const TYPE *words, uint32_t count) \\
    {                                                                                 \\
        (void)device;                                                                 \\
        for (uint32_t at = 0; at < count; at++)                                       \\
            printf("%lld ", (long long)words[at]);                                    \\
        printf("\\n");                                                                \\
        return TFRA_OK;                                                               \\
    }
#define COMMA ,
TABLE(tfra_set_offsets, int32_t, COMMA uint32_t first)
TABLE(tfra_set_gains, uint32_t, COMMA uint32_t first)
TABLE(tfra_set_repairs, uint32_t, )

int main(void) { return (int)tfra_calibrate(NULL); }
"""
"""Prints what a calibration hands to the driver."""


def test_a_calibration_becomes_the_same_tables_in_both_languages(
    package: Path, host: ModuleType, tmp_path: Path
) -> None:
    settings = front_end.Settings(12, is_unsigned=True, invert=True)
    offsets, gains = np.array([-131072, 0, 5, 131071]), np.array([0, 1, 32768, 131071])
    repairs = {0: {1: 0.5, 3: -0.25}, 2: {3: 1.0}}
    tables = front_end.Tables(offsets, gains, np.array(host.repair_words(repairs)))
    (tmp_path / "front_end.h").write_text(header(settings, tables))
    (tmp_path / "main.c").write_text(SHIM)
    folders = [f"-I{package}/driver", f"-I{package}/registers", f"-I{tmp_path}"]
    for compiler in COMPILERS:
        strict = [option for option in STRICT if option != "-Wmissing-prototypes"]
        subprocess.run(
            [compiler, *strict, "-Wno-unused-parameter", *folders, "-o", tmp_path / "main", tmp_path / "main.c"],
            check=True,
        )
    printed = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout.splitlines()
    assert printed[0].split() == ["12", "1", "1", "3"]
    lists = [[int(word) for word in line.split()] for line in printed[1:]]
    assert lists == [offsets.tolist(), gains.tolist(), host.repair_words(repairs)]

    class Written(host.Core):
        """The same, without a core."""

        def __init__(self) -> None:
            self.taxels, self.calls = 4, []

        def get_front_end(self) -> Any:
            return host.FrontEnd(16, dead_band=3)

        def __getattribute__(self, name: str) -> Any:
            if name.startswith("set_"):
                return lambda *given: self.calls.append((name, *given))
            return super().__getattribute__(name)

    core = Written()
    core.calibrate(json.loads(as_json(settings, tables)))
    assert core.calls == [
        ("set_front_end", host.FrontEnd(12, is_unsigned=True, invert=True, dead_band=3)),
        ("set_offsets", 0, offsets.tolist()),
        ("set_gains", 0, gains.tolist()),
        ("set_repairs", repairs),
    ]
    with pytest.raises(ValueError, match="tables of 4 taxels are needed, got 3"):
        core.calibrate({"gains": [1, 2, 3], "offsets": [1, 2, 3], "settings": {}, "repairs": {}})


def test_faults_of_a_frame_have_the_places_of_errors() -> None:
    """And the header has room for all of them."""
    errors = {field.name: field.low for field in MAP["ERRORS"].fields}
    assert FAULTS.items() <= errors.items()
    assert HEADER["faults"][2] == max(errors.values()) + 1
