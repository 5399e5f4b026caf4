"""Simulate a core: frames in, result words and cycle counts out, by any of the simulators."""

import json
import shutil
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface import microarchitecture as hdl
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.runtime.digest import digest, sources, texts
from tfra.runtime.errors import InputError
from tfra.runtime.processes import ToolError, beyond, running
from tfra.runtime.scratch import scratch, writing
from tfra.runtime.store import Files, cache_directory, cached
from tfra.sim import tools
from tfra.sim.launch import WAVES
from tfra.sim.protocol import Job, Outcome, Probe

Progress = Callable[[int], None]
"""Called with the number of frames finished since the last call."""

_LOG_TAIL = 2000  # characters of a log in an error
_POLL = 0.05  # seconds
_LAUNCHER = Path(__file__).with_name("launch.py")


class SimulationError(RuntimeError):
    """A simulation that could not be carried out; the message ends with the tail of the log."""


class ProtocolError(RuntimeError):
    """The core broke the rules of its streams.

    ``violations`` says how; ``words`` are the patterns it sent, ``compared`` and ``mismatches`` count them.
    """

    def __init__(self, outcome: Outcome) -> None:
        super().__init__("; ".join(outcome.violations))
        self.violations = outcome.violations
        self.words = outcome.words
        self.compared, self.mismatches = outcome.compared, outcome.mismatches


@dataclass(frozen=True)
class Netlist:
    """A core in Verilog: the text ``verilog`` with the module ``top``.

    ``images`` are texts by file name, for it to read; ``models`` texts to compile with it: behaviour of the cells that
    it instantiates.
    """

    top: str
    verilog: str
    sidecar: dict[str, Any]
    images: Mapping[str, str] = field(default_factory=dict)
    models: tuple[str, ...] = ()
    probes: tuple[Probe, ...] = ()
    """Streams between blocks, in the order of the data."""


@dataclass(frozen=True)
class Run:
    """What came out of a simulation of n frames.

    ``words (n, frame_words)`` equal those of :class:`tfra.model.fixed.tfra.pipeline.FixedTfra`.  ``latency (n,)``
    counts cycles from a frame's last taxel to its first result word, ``interval (n - 1,)`` those between last words.
    """

    words: Ints
    latency: Ints
    interval: Ints
    simulator: str
    cycles: int
    compared: int
    """Words that the testbench compared with expected ones."""
    mismatches: int
    """Of these, the ones that differed."""
    probes: dict[str, Ints]
    """By stage ``(n, words of a frame)``, when probes were asked for; rows that are not complete are left out."""


def simulate(
    design: Design,
    codes: Ints,
    simulator: str | None = None,
    seed: int = 0,
    stall_in: str = "none",
    stall_out: str = "none",
    build_dir: str | Path | None = None,
    progress: Progress | None = None,
    *,
    expected: Ints | None = None,
    core: Netlist | Any = None,
    probes: bool = False,
    waves: Path | None = None,
) -> Run:
    """Run converter ``codes (n, rows, columns)`` through the core of ``design`` after a reset.

    Args:
        simulator: ``"verilator"``, ``"icarus"`` or ``"amaranth"``; by default the fastest that is usable here.
        seed: Of the stall patterns.
        stall_in, stall_out: ``"none"``, ``"random"`` or ``"bursts"`` on the taxel and the result port.
        build_dir: Directory that keeps builds for the next run, see ``cache_directory``.
        progress: Called with numbers of finished frames.
        expected: Result words ``(n, frame_words)`` to compare with in the testbench.
        core: Another core with the same ports: a ``Netlist``, or a component for ``"amaranth"``.
        probes: Record the streams between blocks; not available in ``"amaranth"``.
        waves: A VCD file to write, with every signal of the core.

    Raises:
        InputError: The simulator is not usable, or not for a core with Verilog cells; the message says what is.
        ProtocolError: The core broke a stream's rules or hung.
        SimulationError: Building or running failed.
    """
    chosen = tools.choose(simulator)
    if not codes.size:
        raise ValueError("codes: at least one frame is needed")
    if chosen == "amaranth":
        if isinstance(core, Netlist) or (core is None and microarchitecture(design).cell_models):
            raise InputError("simulator", chosen, f"can't run Verilog, Icarus can: {tools.ICARUS_INSTALL}")
        job = _job(design, codes, seed, stall_in, stall_out, expected, ())
        return _run(design, job, _run_pysim(design, job, core, progress, waves), chosen)
    cache = cache_directory(build_dir)
    netlist = core or generated(design, cache)
    job = _job(design, codes, seed, stall_in, stall_out, expected, netlist.probes if probes else ())
    return _run(design, job, _run_cocotb(netlist, job, chosen, cache, progress, waves), chosen)


def generated(design: Design, cache: Path) -> Netlist:
    """Return the generated core of ``design``, from ``cache`` if the same sources have made it before."""
    from tfra import codegen, families, hdl, model, runtime

    key = digest(repr(design), tools.versions(), *texts(sources(codegen, families, hdl, model, runtime)))
    files = cached(cache / f"core-{design.name}-{key}", lambda: _generate(design))
    images = {name: content.decode() for name, content in files.items()}  # and what else was made
    verilog, sidecar = images.pop(f"{design.name}.v"), json.loads(images.pop(f"{design.name}.json"))
    core = microarchitecture(design)
    probes = tuple(_watched(probe) for probe in core.probes)
    return Netlist(design.name, verilog, sidecar, images, tuple(texts(core.cell_models)), probes)


def _watched(probe: hdl.Probe) -> Probe:
    place = f"core.probe_{probe.stage}"
    return Probe(probe.stage, place, f"{place}_words", probe.words, probe.transfers)


def _generate(design: Design) -> Files:
    from tfra.codegen.verilog.files import files

    try:
        made = files(design)
    except ToolError as error:
        raise SimulationError(str(error)) from None
    facts = json.loads(made[f"{design.name}.json"])
    names = [f"{design.name}.v", f"{design.name}.json", *(image["file"] for image in facts["images"])]
    return {name: made[name].encode() for name in names}


def _build(netlist: Netlist, simulator: str, cache: Path, waves: bool) -> bytes:
    """Return the executable for ``netlist``, from ``cache`` if it is there."""
    watched = [path for probe in netlist.probes for path in (probe.transfer, probe.words)]
    compiled = {f"{netlist.top}.v": netlist.verilog}
    compiled |= {f"model{number}.v": text for number, text in enumerate(netlist.models)}
    if simulator == "verilator":
        compiled["public.vlt"] = tools.public_signals(netlist.top, watched)
    elif waves:
        compiled["waves.v"] = tools.waves_module(netlist.top)
    action = "build+waves" if waves else "build"
    key = digest(action, *compiled.values(), tools.versions(), tools.programs(simulator), *texts([_LAUNCHER]))
    place = cache / f"build-{netlist.top}-{simulator}-{key}"

    def make() -> Files:
        with scratch(cache) as folder:
            for name, text in compiled.items():
                (folder / name).write_text(text)
            _launch([action, simulator, netlist.top, *compiled], folder, f"building for {simulator}")
            return {"executable": (folder / tools.executable(simulator, netlist.top)).read_bytes()}

    return cached(place, make)["executable"]


def _job(
    design: Design,
    codes: Ints,
    seed: int,
    stall_in: str,
    stall_out: str,
    expected: Ints | None,
    probes: tuple[Probe, ...],
) -> Job:
    core = microarchitecture(design)
    return Job(
        _patterns(codes, design.adc.bits),
        design.sensor.taxels,
        design.frame_words,
        None if expected is None else _patterns(expected, design.word_bits),
        None if core.loaded is None else _patterns(core.loaded, design.coefficient_word),
        seed,
        stall_in,
        stall_out,
        _patience(core),
        probes=probes,
    )


def _patterns(words: Ints, bits: int) -> list[int]:
    """Words as two's complement patterns of ``bits``."""
    patterns: list[int] = (np.asarray(words, dtype=np.int64).ravel() & ((1 << bits) - 1)).tolist()
    return patterns


def _patience(core: hdl.Microarchitecture) -> int:
    """Upper bound on the cycles of a frame for any core."""
    m, design = core.design.sensor.taxels, core.design
    products = 8 * (4 * design.quads) ** 2 // core.lanes
    return 10_000 + 4 * (products + 32 * m + 8 * design.candidates)


def _run(design: Design, job: Job, outcome: Outcome, simulator: str) -> Run:
    if outcome.violations:
        raise ProtocolError(outcome)
    half = 1 << (design.word_bits - 1)
    words = ((np.array(outcome.words, dtype=np.int64) ^ half) - half).reshape(-1, job.frame_words)
    return Run(
        words,
        np.subtract(outcome.first_word, outcome.last_taxel),
        np.diff(outcome.last_word),
        simulator,
        outcome.cycles,
        outcome.compared,
        outcome.mismatches,
        {probe.stage: _rows(probe, packed) for probe, packed in zip(job.probes, outcome.probes, strict=False)},
    )


def _rows(probe: Probe, packed: list[int]) -> Ints:
    frames = len(packed) // probe.transfers
    words = probe.unpack(packed[: frames * probe.transfers])
    return np.array(words, dtype=np.int64).reshape(frames, -1)


def _run_pysim(design: Design, job: Job, core: Any, progress: Progress | None, waves: Path | None) -> Outcome:
    from tfra.sim import pysim

    return pysim.run(core or microarchitecture(design).build(), job, progress, waves)


def _run_cocotb(
    netlist: Netlist, job: Job, simulator: str, cache: Path, progress: Progress | None, waves: Path | None
) -> Outcome:
    program = _build(netlist, simulator, cache, waves is not None)
    with scratch(cache) as folder, writing(folder.parent):
        for name, text in netlist.images.items():
            (folder / name).write_text(text)
        executable = folder / tools.executable(simulator, netlist.top)
        executable.write_bytes(program)
        executable.chmod(0o700)
        files = {key: folder / f"tfra_{key}" for key in ("job.json", "outcome.json", "progress")}
        job.save(files["job.json"])
        watcher = _ProgressFile(files["progress"], progress) if progress else None
        variables = {f"TFRA_{key.partition('.')[0].upper()}": str(file) for key, file in files.items()}
        action = "test+waves" if waves else "test"
        log = _launch([action, simulator, netlist.top], folder, f"simulating with {simulator}", variables, watcher)
        try:
            outcome = Outcome.load(files["outcome.json"])
        except (OSError, ValueError):
            raise SimulationError(f"simulating with {simulator} gave no outcome:\n{log}") from None
        if watcher:
            watcher.report(job.frames)
        if waves:
            shutil.move(folder / WAVES, waves)
        return outcome


class _ProgressFile:
    """Reports the progress that the testbench notes in a file."""

    def __init__(self, file: Path, progress: Progress) -> None:
        self._file, self._progress, self._done = file, progress, 0

    def read(self) -> None:
        """Read the testbench's note."""
        try:
            self.report(int(self._file.read_text()))
        except (OSError, ValueError):  # not there yet, or being written
            return

    def report(self, frames: int) -> None:
        """Report ``frames`` in total."""
        if frames > self._done:
            self._progress(frames - self._done)
            self._done = frames


def _launch(
    arguments: list[str],
    place: Path,
    what: str,
    variables: Mapping[str, str] | None = None,
    watcher: _ProgressFile | None = None,
) -> str:
    """Run ``tfra.sim.launch`` in ``place`` and return the tail of its log; raises ``SimulationError`` on failure."""
    log = place / "tfra.log"
    command = [sys.executable, "-m", "tfra.sim.launch", *arguments]
    environment = tools.environment(arguments[1], place, "+waves" in arguments[0]) | dict(variables or {})
    with log.open("w") as stream, running(command, place, environment, stdout=stream) as process:
        while process.poll() is None:
            time.sleep(_POLL)
            if watcher:
                watcher.read()
    tail = log.read_text(errors="replace")[-_LOG_TAIL:]
    if process.returncode:
        reason = beyond(process.returncode, tail)
        raise SimulationError(f"{what} failed: {reason}" if reason else f"{what} failed:\n{tail}")
    return tail
