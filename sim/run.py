"""Simulate a core: frames in, result words and cycle counts out, by any of the simulators."""

import json
import shutil
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.skin.payloads import setting_ports
from tfra.hdl.skin.unit import SkinUnit
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.skin.records import ends as last_records
from tfra.model.skin.records import result_shape
from tfra.model.skin.skin import Skin, core_of
from tfra.runtime.digest import digest, sources
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
    """The core broke the rules of its streams: the violations of ``outcome`` say how."""

    def __init__(self, outcome: Outcome) -> None:
        super().__init__("; ".join(outcome.violations))
        self.outcome = outcome


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

    ``words (n, frame_words)`` equal those of the design's model; of a skin, they are
    :func:`tfra.model.skin.records.records`.  ``latency (n,)`` counts cycles from a frame's last taxel to its first
    result word, ``interval (n - 1,)`` those between last words.
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
    array: Design | Skin,
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
    """Run converter ``codes (n, rows, columns)`` through the core of a design or a skin after a reset.

    Of a skin, records take the place of result frames.

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
    gateware, cache, netlist = microarchitecture(core_of(array)), cache_directory(build_dir), None
    if chosen != "amaranth":
        netlist = core or generated(array, cache)
    elif isinstance(core, Netlist) or (core is None and gateware.cell_models):
        raise InputError("simulator", chosen, f"can't run Verilog, Icarus can: {tools.ICARUS_INSTALL}")
    job = replace(
        _job(array, gateware, codes, expected),
        seed=seed,
        stall_in=stall_in,
        stall_out=stall_out,
        probes=netlist.probes if netlist and probes else (),
    )
    if progress and isinstance(array, Skin):
        progress = _by_frame(progress, _records(array, codes))
    if netlist:
        outcome = _run_cocotb(netlist, job, chosen, cache, progress, waves)
    else:
        from tfra.sim import pysim

        built = SkinUnit(array) if isinstance(array, Skin) else gateware.build()
        outcome = pysim.run(core or built, job, progress, waves)
    return _run(array, job, outcome, chosen)


def _job(array: Design | Skin, gateware: Microarchitecture, codes: Ints, expected: Ints | None) -> Job:
    """The job without stalls."""
    words, bits = result_shape(array)
    results, patience, settings = len(codes), _patience(gateware), {}
    if isinstance(array, Skin):
        results = int(_records(array, codes).sum())
        patience += 64 * array.sensor.taxels
        settings = {name: port.init for name, port in setting_ports(array).items()}
    return Job(
        _patterns(codes, array.adc.bits),
        array.sensor.taxels,
        words,
        results,
        None if expected is None else _patterns(expected, bits),
        None if gateware.loaded is None else _patterns(gateware.loaded, gateware.design.coefficient_word),
        patience=patience,
        settings=settings,
    )


def _records(skin: Skin, codes: Ints) -> Ints:
    """Records of each frame."""
    return np.maximum(skin.find(codes)[0].found, 1)


def _by_frame(progress: Progress, records: Ints) -> Progress:
    """``progress`` in frames for a simulation that counts their ``records``."""
    ends, counts = np.cumsum(records), np.zeros(2, dtype=np.int64)

    def finished(more: int) -> None:
        done = counts[0] + more
        whole = np.searchsorted(ends, done, side="right")
        progress(int(whole - counts[1]))
        counts[:] = done, whole

    return finished


def generated(array: Design | Skin, cache: Path) -> Netlist:
    """Return the generated core of a design or a skin, from ``cache`` if the same sources have made it before."""
    from tfra import codegen, families, hdl, model, runtime

    key = digest(repr(array), tools.versions(), *sources(codegen, families, hdl, model, runtime))
    files = cached(cache / f"core-{array.name}-{key}", lambda: _generate(array))
    images = {name: content.decode() for name, content in files.items()}  # and what else was made
    verilog, sidecar = images.pop(f"{array.name}.v"), json.loads(images.pop(f"{array.name}.json"))
    core = microarchitecture(core_of(array))
    inner = "core.core" if isinstance(array, Skin) else "core"
    places = ((probe, f"{inner}.probe_{probe.stage}") for probe in core.probes)
    probes = tuple(Probe(one.stage, place, f"{place}_words", one.words, one.transfers) for one, place in places)
    models = tuple(file.read_text() for file in core.cell_models)
    return Netlist(array.name, verilog, sidecar, images, models, probes)


def _generate(array: Design | Skin) -> Files:
    from tfra.codegen.verilog.files import files

    try:
        made = files(array)
    except ToolError as error:
        raise SimulationError(str(error)) from None
    facts = json.loads(made[f"{array.name}.json"])
    names = [f"{array.name}.v", f"{array.name}.json", *(image["file"] for image in facts["images"])]
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
    key = digest(action, *compiled.values(), tools.versions(), tools.programs(simulator), _LAUNCHER.read_text())
    place = cache / f"build-{netlist.top}-{simulator}-{key}"

    def make() -> Files:
        with scratch(cache) as folder:
            for name, text in compiled.items():
                (folder / name).write_text(text)
            _launch([action, simulator, netlist.top, *compiled], folder, f"building for {simulator}")
            return {"executable": (folder / tools.executable(simulator, netlist.top)).read_bytes()}

    return cached(place, make)["executable"]


def _patterns(words: Ints, bits: int) -> list[int]:
    """Words as two's complement patterns of ``bits``."""
    patterns: list[int] = (np.asarray(words, dtype=np.int64).ravel() & ((1 << bits) - 1)).tolist()
    return patterns


def _patience(core: Microarchitecture) -> int:
    """Upper bound on the cycles of a frame for any core."""
    m, design = core.design.sensor.taxels, core.design
    products = 8 * (4 * design.quads) ** 2 // core.lanes
    return 10_000 + 4 * (products + 32 * m + 8 * design.candidates)


def _run(array: Design | Skin, job: Job, outcome: Outcome, simulator: str) -> Run:
    if outcome.violations:
        raise ProtocolError(outcome)
    half = 1 << (result_shape(array)[1] - 1)
    words = ((np.array(outcome.words, dtype=np.int64) ^ half) - half).reshape(-1, job.frame_words)
    first, ends = np.arange(len(words)), np.arange(len(words))  # results that begin and end a frame
    if isinstance(array, Skin):
        ends = np.flatnonzero(last_records(array, words))
        first = np.concatenate([[0], ends[:-1] + 1])
    return Run(
        words,
        np.subtract(np.take(outcome.first_word, first), outcome.last_taxel),
        np.diff(np.take(outcome.last_word, ends)),
        simulator,
        outcome.cycles,
        outcome.compared,
        outcome.mismatches,
        {probe.stage: _rows(probe, packed) for probe, packed in zip(job.probes, outcome.probes, strict=True)},
    )


def _rows(probe: Probe, packed: list[int]) -> Ints:
    frames = len(packed) // probe.transfers
    words = probe.unpack(packed[: frames * probe.transfers])
    return np.array(words, dtype=np.int64).reshape(frames, -1)


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
        follow = _follower(files["progress"], progress)
        variables = {f"TFRA_{key.partition('.')[0].upper()}": str(file) for key, file in files.items()}
        action = "test+waves" if waves else "test"
        log = _launch([action, simulator, netlist.top], folder, f"simulating with {simulator}", variables, follow)
        try:
            outcome = Outcome.load(files["outcome.json"])
        except (OSError, ValueError):
            raise SimulationError(f"simulating with {simulator} gave no outcome:\n{log}") from None
        if waves:
            shutil.move(folder / WAVES, waves)
        return outcome


def _follower(file: Path, progress: Progress | None) -> Callable[[], None]:
    """A function that reports the frames finished since its last call, as the testbench notes them in ``file``."""
    done = 0

    def follow() -> None:
        nonlocal done
        try:
            frames = int(file.read_text())
        except (OSError, ValueError):  # not there yet, or being written
            return
        if progress and frames > done:
            progress(frames - done)
        done = frames

    return follow


def _launch(
    arguments: list[str],
    place: Path,
    what: str,
    variables: Mapping[str, str] | None = None,
    follow: Callable[[], None] = lambda: None,
) -> str:
    """Run ``tfra.sim.launch`` in ``place`` and return the tail of its log; raises ``SimulationError`` on failure."""
    log = place / "tfra.log"
    command = [sys.executable, "-m", "tfra.sim.launch", *arguments]
    environment = tools.environment(arguments[1], place, "+waves" in arguments[0]) | dict(variables or {})
    with log.open("w") as stream, running(command, place, environment, stdout=stream) as process:
        while process.poll() is None:
            time.sleep(_POLL)
            follow()
    follow()
    tail = log.read_text(errors="replace")[-_LOG_TAIL:]
    if process.returncode:
        reason = beyond(process.returncode, tail)
        raise SimulationError(f"{what} failed: {reason}" if reason else f"{what} failed:\n{tail}")
    return tail
