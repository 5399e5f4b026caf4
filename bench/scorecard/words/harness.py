"""A core in Verilator beside the same core in C: built once, then fed with frames by ``harness.cpp``."""

import json
import subprocess
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from bench.exactness.axi import CHECK_SEQUENCE, CUT_THROUGH, FORCES, RUN
from tfra.codegen.c.memory import ram_bytes, size_of
from tfra.codegen.c.skin import skin_ram_bytes
from tfra.codegen.verilog.wrapper import module_name, wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.hdl.skin.payloads import setting_ports
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.skin.records import header_bits, records, result_shape
from tfra.model.skin.skin import Skin, core_of
from tfra.runtime.processes import ToolError, complaint, running
from tfra.runtime.store import cache_directory
from tfra.sim.compiled import library
from tfra.sim.compiled_skin import skin_library
from tfra.sim.run import generated
from tfra.sim.tools import choose, environment

SOURCE = Path(__file__).with_name("harness.cpp")
HEAD = 2
"""Words in front of the result words of a frame behind AXI."""


@dataclass(frozen=True)
class Configuration:
    """A core, alone or behind AXI."""

    name: str
    array: Design | Skin
    wrapped: bool = False
    cut_through: bool = False

    @property
    def design(self) -> Design:
        """The only design, or that of a window."""
        return core_of(self.array)

    @property
    def header(self) -> int:
        """Words in front of those of a window."""
        return len(header_bits(self.array)) if isinstance(self.array, Skin) else 0

    @cached_property
    def macros(self) -> Mapping[str, Any]:
        """What the harness has to know."""
        design, array = self.design, self.array
        core, (words, bits), skin = microarchitecture(design), result_shape(array), isinstance(array, Skin)
        control = RUN | FORCES | CHECK_SEQUENCE | CUT_THROUGH * self.cut_through
        settings = setting_ports(array) if isinstance(array, Skin) and not self.wrapped else {}
        return {
            "ROWS": array.sensor.rows,
            "COLUMNS": array.sensor.columns,
            "TAXELS": array.sensor.taxels,
            "CODE": f"int{8 * size_of(array.adc.bits)}_t",
            "CODE_BITS": array.adc.bits,
            "RECORD_WORDS": words,
            "WORD_BITS": bits,
            "HEADER": self.header,
            "COUNTER": (1 << COUNTER_BITS) - 1,
            "MOST": array.choices.most if isinstance(array, Skin) else 1,
            "STATE_BYTES": skin_ram_bytes(array) if isinstance(array, Skin) else ram_bytes(array),
            "PER_BEAT": design.bus.taxels_per_beat if self.wrapped else 0,
            "CONTROL": control,
            "LOADED": int(core.loaded is not None),
            "CHECKSUM": f"{zlib.crc32(self.coefficients)}u",
            "SETTINGS": " ".join(f"top.{name} = {int(port.init)};" for name, port in settings.items()),
            "PATIENCE": 20_000 + 20 * core.frame_latency + 64 * array.sensor.taxels * (1 + 16 * skin),
            "STRIDE": 997,
        }

    @property
    def top(self) -> str:
        """The name of the outermost module."""
        return module_name(self.array) if self.wrapped else self.array.name

    @cached_property
    def texts(self) -> dict[str, str]:
        """Verilog and images, by the files' names."""
        made = generated(self.array, cache_directory())
        texts = {f"{self.array.name}.v": made.verilog, **made.images}
        texts |= {f"model{number}.v": text for number, text in enumerate(made.models)}
        return texts | ({f"{self.top}.v": wrapper_verilog(self.array)} if self.wrapped else {})

    @property
    def coefficients(self) -> bytes:
        """Those that are loaded after a reset, 32 bits each."""
        loaded = microarchitecture(self.design).loaded
        return b"" if loaded is None else np.asarray(loaded).ravel().astype("<i4").tobytes()


@dataclass(frozen=True)
class Outcome:
    """What the harness found: ``counts`` by name, and a sample: ``codes (n, taxels)``, and the words of each frame."""

    counts: dict[str, Any]
    codes: Ints
    words: list[Ints]

    @property
    def passed(self) -> bool:
        """Whether all words came, and none of them differs or breaks the rules of the streams."""
        return not (self.counts["differ"] or self.counts["broken"] or self.counts["missing"])


def built(
    configuration: Configuration,
    folder: Path,
    source: Path = SOURCE,
    texts: Mapping[str, str] | None = None,
    settings: str = "",
    options: Iterable[str] = (),
) -> Path:
    """The program of ``source`` around the Verilated ``configuration``, in the empty ``folder``.

    ``texts`` are files to take in place of its own Verilog, ``settings`` statements that set more ports at a reset, and
    ``options`` of Verilator.  Raises ``ToolError`` where it can't be built.
    """
    array = configuration.array
    macros = dict(configuration.macros)
    macros["SETTINGS"] += settings
    shape = "".join(f"#define {name} {value}\n" for name, value in macros.items())
    texts = {**(configuration.texts if texts is None else texts), "shape.h": f"#include <stdint.h>\n{shape}"}
    for name, text in texts.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    (folder / "coefficients").write_bytes(configuration.coefficients)
    (folder / "core.so").write_bytes(skin_library(array) if isinstance(array, Skin) else library(array))
    choose("verilator")
    command = ["verilator", "--cc", "--exe", "--build", "-O3", "-Wno-fatal", "-Wno-lint", "--prefix", "Vtop"]
    command += ["--top-module", configuration.top, "--Mdir", str(folder / "made"), *options]
    command += ["-CFLAGS", f"-std=gnu++20 -I{folder} -I{SOURCE.parent}"]
    command += ["-MAKEFLAGS", "OPT_FAST=-O2", "-MAKEFLAGS", "OPT_GLOBAL=-O0"]  # Verilator's own code takes long
    command += ["-LDFLAGS", "-ldl", "-o", "harness", str(source)]
    verilog = [str(folder / name) for name in texts if name.endswith(".v")]
    with running([*command, *verilog], folder, environment("verilator", folder)) as process:
        said, _ = process.communicate()
    if process.returncode:
        raise ToolError(complaint("verilator", process.returncode, said))
    return folder / "made" / "harness"


def ran(program: Path, *arguments: object) -> str:
    """What a ``program`` of :func:`built` prints, run in its folder; raises ``ToolError`` where it fails."""
    command = [str(program), *map(str, arguments)]
    done = subprocess.run(command, cwd=program.parents[1], capture_output=True, text=True, check=False)
    if done.returncode:
        raise ToolError(complaint(program.name, done.returncode, done.stderr))
    return done.stdout


class Harness:
    """The program ``harness.cpp`` for a ``configuration`` in an empty ``folder``; the rest is that of :func:`built`."""

    def __init__(self, configuration: Configuration, folder: Path, **how: Any) -> None:
        self.configuration, self.folder = configuration, folder
        self._program = built(configuration, folder, **how)

    def run(self, given: Ints, frames: int, seed: int) -> Outcome:
        """Send the codes ``given (n, rows, columns)``, then so many random ``frames``."""
        (self.folder / "given").write_bytes(given.astype("<i4").tobytes())
        counts = json.loads(ran(self._program, "./core.so", seed, frames, "given", "sample"))
        codes, words = self._sample((self.folder / "sample").read_bytes())
        return Outcome(counts, codes, words)

    def _sample(self, data: bytes) -> tuple[Ints, list[Ints]]:
        taxels, place = self.configuration.array.sensor.taxels, 0
        codes, words = [], []
        while place < len(data):
            codes.append(np.frombuffer(data, "<i4", taxels, place))
            place += 4 * taxels
            count = int(np.frombuffer(data, "<i8", 1, place)[0])
            words.append(np.frombuffer(data, "<i8", count, place + 8))
            place += 8 + 8 * count
        return np.array(codes, dtype=np.int64).reshape(-1, taxels), words


def replayed(configuration: Configuration, outcome: Outcome) -> tuple[int, int]:
    """Words of the sample that are compared with the model in Python, and those that differ; counters aside.

    The harness's own words are those of the core in C, so that the C is no blind spot.
    """
    array, design = configuration.array, configuration.design
    codes = outcome.codes.reshape(-1, array.sensor.rows, array.sensor.columns)
    words, bits = result_shape(array)
    made = (
        records(array, codes, lambda of: design.model(of).words)
        if isinstance(array, Skin)
        else design.model(codes).words
    )
    flat = np.concatenate(outcome.words).reshape(-1, words + HEAD * configuration.wrapped)[:, -words:]
    half = 1 << (bits - 1)
    same = ((flat & ((1 << bits) - 1)) ^ half) - half == made
    counters = [0, configuration.header]
    return int(np.delete(same, counters, axis=1).size), int((~np.delete(same, counters, axis=1)).sum())
