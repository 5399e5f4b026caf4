"""The simulators on a stand-in core that can be told to go wrong."""

import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tests.marks import long
from tfra.hdl.interface import ports
from tfra.model.arrays import Ints
from tfra.model.choices import Architecture, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import InputError
from tfra.runtime.store import cached
from tfra.sim import run as run_module
from tfra.sim.protocol import Probe
from tfra.sim.run import Netlist, ProtocolError, Run, SimulationError, simulate

DESIGN = TfraDesign(
    SensorArray(2, 2, 4e-3, 2e-3, 3e-3),
    name="tiny",
    search=Search(8),
    architecture=Architecture(4),
)
WORDS = DESIGN.frame_words
FRAMES = 5
LATENCY = 6
INTERVAL = DESIGN.sensor.taxels + LATENCY + WORDS - 1

IN_SHORT = ["icarus", *long("verilator")]
"""Faults are noticed by what both simulators share; a build of Verilator takes long."""

MORE = (("bursts", "random"), ("bursts", "bursts"), ("random", "random"), ("none", "random"), ("bursts", "none"))
"""Stalls of both ports that only long tests try."""

CORRUPT, NO_LAST, DROP, CHANGE, WITHDRAW, STOP, SURPLUS = range(1, 8)

Maker = Callable[..., Netlist]
Play = Callable[..., Run]


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def codes() -> Ints:
    return np.random.default_rng(5).integers(-8192, 8192, (FRAMES, 2, 2))


@pytest.fixture(scope="module")
def words(codes: Ints) -> Ints:
    return FixedTfra(DESIGN)(codes).words


@pytest.fixture
def standin(words: Ints) -> Maker:
    """Make a stand-in that sends the model's words, with a fault at a word."""

    def make(fault: int = 0, at: int = 0) -> Netlist:
        text = (Path(__file__).parent / "standin.v").read_text()
        sizes = {"ADC": DESIGN.adc.bits, "BITS": DESIGN.word_bits, "TAXELS": DESIGN.sensor.taxels, "WORDS": WORDS}
        for name, value in sizes.items():
            text = text.replace(f"@{name}@", str(value))
        mask = (1 << DESIGN.word_bits) - 1
        sent = "".join(f"{word & mask:x}\n" for word in words.ravel().tolist())
        images = {"words.hex": sent, "setup.hex": f"{fault:x}\n{at:x}\n"}
        layout = ((DESIGN.adc.bits, True),)
        probe = Probe("input", "probe_input", "probe_input_words", layout, DESIGN.sensor.taxels)
        facts = {"latency_cycles": {"first_word": LATENCY}, "interval_cycles": INTERVAL}
        return Netlist("standin", text, facts, images, probes=(probe,))

    return make


@pytest.fixture
def play(cache: Path, codes: Ints) -> Play:
    """Run all frames through a core, in Icarus unless another simulator is named."""

    def run(core: Any, simulator: str = "icarus", **options: Any) -> Run:
        return simulate(DESIGN, codes, simulator, **{"build_dir": cache, "core": core, **options})

    return run


@pytest.mark.parametrize(
    ("simulator", "stall_in", "stall_out"),
    [
        ("icarus", "none", "none"),
        ("icarus", "random", "bursts"),
        *long(
            ("verilator", "none", "none"),
            ("verilator", "random", "bursts"),
            *(("icarus", *pair) for pair in MORE),
        ),
    ],
)
def test_words_arrive(
    simulator: str, stall_in: str, stall_out: str, codes: Ints, words: Ints, standin: Maker, play: Play
) -> None:
    progress: list[int] = []
    stalls = {"seed": 3, "stall_in": stall_in, "stall_out": stall_out}
    run = play(standin(), simulator, progress=progress.append, expected=words, probes=True, **stalls)
    np.testing.assert_array_equal(run.words, words)
    assert (run.compared, run.mismatches) == (words.size, 0)
    assert run.simulator == simulator
    assert sum(progress) == FRAMES
    np.testing.assert_array_equal(run.probes["input"], codes.reshape(FRAMES, -1))
    if stall_in == stall_out == "none":
        assert run.latency.tolist() == [LATENCY] * FRAMES
        assert run.interval.tolist() == [INTERVAL] * (FRAMES - 1)
    assert run.cycles >= FRAMES * INTERVAL


@pytest.mark.parametrize("simulator", IN_SHORT)
@pytest.mark.parametrize("at", [WORDS + 4, *long(0, FRAMES * WORDS - 1)])
def test_a_corrupt_word_is_a_mismatch(simulator: str, at: int, words: Ints, standin: Maker, play: Play) -> None:
    run = play(standin(CORRUPT, at), simulator, expected=words)
    assert np.flatnonzero((run.words != words).ravel()).tolist() == [at]
    assert (run.compared, run.mismatches) == (words.size, 1)


@pytest.mark.parametrize("simulator", IN_SHORT)
@pytest.mark.parametrize(
    ("fault", "at", "stall", "note"),
    [
        (CHANGE, WORDS + 3, "random", "frame 1, word 3: payload changed from"),
        (SURPLUS, FRAMES * WORDS - 1, "none", "a word follows the last frame"),
        *long(
            (NO_LAST, 2 * WORDS - 1, "none", f"frame 1, word {WORDS - 1}: last is missing"),
            (DROP, WORDS + 3, "none", f"frame 1, word {WORDS - 2}: last is set too early"),
            (WITHDRAW, WORDS + 3, "random", "frame 1, word 3: valid was withdrawn"),
            (STOP, WORDS + 3, "random", f"cycles after {WORDS + 3} of {FRAMES * WORDS} words"),
        ),
    ],
)
def test_a_broken_rule_is_an_error(
    simulator: str, fault: int, at: int, stall: str, note: str, standin: Maker, play: Play
) -> None:
    for seed in range(20):  # some seed stalls at the word in question
        try:
            play(standin(fault, at), simulator, seed=seed, stall_out=stall)
        except ProtocolError as error:
            assert note in str(error), seed  # noqa: PT017  # seeds that break no rule go on
            return
    pytest.fail(f"fault {fault} went unseen")


def test_the_second_run_needs_no_build(standin: Maker, play: Play, monkeypatch: pytest.MonkeyPatch) -> None:
    play(standin())
    monkeypatch.setattr(run_module, "cached", lambda place, make: cached(place, lambda: pytest.fail("built again")))
    run = play(standin(CORRUPT, 1))
    assert (run.compared, run.mismatches, run.probes) == (0, 0, {})  # without expected words and probes


@pytest.mark.parametrize("change", ["verilog", "models", "probes", "programs"])
def test_another_core_or_compiler_has_another_build(
    tmp_path: Path, standin: Maker, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    """Models of cells are compiled in; Verilator has to be told what probes look at."""
    named, core = list[str](), standin()
    other = {"verilog": core.verilog + "\n", "models": ("module cell; endmodule",), "probes": ()}
    monkeypatch.setattr(run_module, "cached", lambda place, make: named.append(place.name) or {"executable": b""})
    run_module._build(core, "verilator", tmp_path, False)
    run_module._build(core, "verilator", tmp_path, False)
    if change == "programs":
        monkeypatch.setattr(run_module.tools, "programs", lambda simulator: "g++ of tomorrow")
    else:
        core = replace(core, **{change: other[change]})
    run_module._build(core, "verilator", tmp_path, False)
    assert named[0] == named[1] != named[2]


def test_a_killed_simulator_is_told_in_a_line(
    tmp_path: Path, standin: Maker, play: Play, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = tmp_path / "bin" / "vvp"
    fake.parent.mkdir()
    fake.write_text("#!/bin/sh\nkill -KILL $$\n")
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", f"{fake.parent}:{os.environ['PATH']}")
    with pytest.raises(SimulationError) as error:
        play(standin(), build_dir=tmp_path / "c")
    assert str(error.value) == "simulating with icarus failed: killed by SIGKILL: is there enough memory?"


def test_a_full_disk_is_told_in_a_line(
    cache: Path, standin: Maker, play: Play, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(run_module.Job, "save", full)
    with pytest.raises(InputError) as error:
        play(standin())
    assert str(error.value) == f"{cache}: cannot be written: No space left on device"


def test_a_build_that_fails_tells_why_and_leaves_nothing(tmp_path: Path, standin: Maker, play: Play) -> None:
    core = replace(standin(), verilog="module standin(input wire clk; endmodule")
    with pytest.raises(SimulationError, match=r"(?s)building for icarus failed:.*syntax error"):
        play(core, build_dir=tmp_path / "c")
    assert not list((tmp_path / "c").iterdir())


def test_a_testbench_that_fails_tells_why(standin: Maker, play: Play) -> None:
    core = standin()
    core = replace(core, probes=(replace(core.probes[0], words="no_such_signal"),))
    with pytest.raises(SimulationError, match=r"(?s)gave no outcome:.*there is no no_such_signal below standin"):
        play(core, probes=True)


@pytest.mark.parametrize("simulator", ["icarus", *long("verilator", "amaranth")])
def test_waves_hold_every_change_of_a_port(
    simulator: str, tmp_path: Path, words: Ints, standin: Maker, play: Play
) -> None:
    """What the VCD file says of the result port when words pass it is what the simulation returned."""
    file, core = tmp_path / "waves.vcd", None if simulator == "amaranth" else standin()
    run = play(core, simulator, expected=words, waves=file)
    assert run.mismatches == 0
    seen = changes(file.read_text(), "result__payload.data" if simulator == "amaranth" else "result_data")
    mask = (1 << DESIGN.word_bits) - 1
    assert {word & mask for word in run.words.ravel().tolist()} <= set(seen)


def changes(vcd: str, name: str) -> list[int]:
    """Every value of the first variable called ``name``."""
    found = re.search(rf"\$var \w+ \d+ (\S+) \\?{re.escape(name)}[ \[]", vcd)
    assert found, name
    return [int(value, 2) for value in re.findall(rf"^b([01]+) {re.escape(found[1])}$", vcd, re.MULTILINE)]


def test_no_frames(cache: Path) -> None:
    with pytest.raises(ValueError, match="codes: at least one frame"):
        simulate(DESIGN, np.empty((0, 2, 2), dtype=np.int64), "icarus", build_dir=cache)


@pytest.mark.long
def test_the_core_in_every_simulator(words: Ints, play: Play) -> None:
    """The same vectors in Amaranth's simulator and on the generated Verilog: equal words, equal cycles."""
    runs = [play(None, simulator, expected=words) for simulator in ("amaranth", "icarus")]
    for run in runs:
        np.testing.assert_array_equal(run.words, words)
        assert (run.compared, run.mismatches) == (words.size, 0)
        assert run.latency.tolist() == runs[0].latency.tolist()
        assert run.interval.tolist() == runs[0].interval.tolist()


def test_amaranth_sees_a_hang(play: Play, monkeypatch: pytest.MonkeyPatch) -> None:
    class Silent(wiring.Component):
        def __init__(self) -> None:
            taxel, result = (stream.Signature(port(DESIGN)) for port in (ports.taxel, ports.result))
            super().__init__({"taxel": In(taxel), "result": Out(result)})

        def elaborate(self, platform: object) -> Module:
            m = Module()
            m.d.sync += self.taxel.ready.eq(1)
            return m

    monkeypatch.setattr(run_module, "_patience", lambda design: 50)
    with pytest.raises(ProtocolError, match=f"no transfer in 50 cycles after 0 of {FRAMES * WORDS} words"):
        play(Silent(), "amaranth")
