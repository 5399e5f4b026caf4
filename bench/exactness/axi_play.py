"""Inside of the simulator: frames through a core behind AXI, driven by cocotbext-axi.

``python -m bench.exactness.axi_play SIMULATOR TOP FOLDER`` compiles the Verilog of FOLDER, sends the frames of
``job.json`` with random pauses on both streams while registers are read, and writes ``outcome.json``: the frames that
came back, and the registers at the end.
"""

import json
import random
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles
from cocotb_tools.runner import VerilatorControlFile, get_runner
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiStreamBus, AxiStreamFrame, AxiStreamSink, AxiStreamSource

from tfra.sim.launch import BUILD_ARGUMENTS, TIMESCALE
from tfra.sim.tools import public_signals

LOAD_DATA, LOAD_CHECKSUM, CONTROL, ERRORS = 0x80, 0x88, 0x40, 0x48
COUNTERS = {"FRAMES_IN": 0x60, "FRAMES_OUT": 0x64, "FRAMES_DROPPED": 0x68, "FRAMES_SATURATED": 0x6C}
STATES = {**COUNTERS, "ERRORS": ERRORS, "LOAD_COUNT": 0x84, "FRAME_CYCLES": 0x70}

PERIOD = 10
"""Of the clock, in ns."""


@cocotb.test()
async def play(dut: Any) -> None:
    """All frames of the job in, all answers out."""
    job = json.loads(Path("job.json").read_text())
    source = AxiStreamSource(AxiStreamBus.from_prefix(dut, "s_axis"), dut.aclk, dut.aresetn, False, byte_lanes=1)
    sink = AxiStreamSink(AxiStreamBus.from_prefix(dut, "m_axis"), dut.aclk, dut.aresetn, False, byte_lanes=1)
    manager = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axi"), dut.aclk, dut.aresetn, False)
    dut.aresetn.value = 0
    Clock(dut.aclk, PERIOD, unit="ns").start()
    await ClockCycles(dut.aclk, 4)
    dut.aresetn.value = 1
    await ClockCycles(dut.aclk, 2)
    await load(manager, job["coefficients"])
    await write(manager, CONTROL, job["control"])
    if job["pauses"]:
        source.set_pause_generator(pauses(random.Random(job["seed"])))
        sink.set_pause_generator(pauses(random.Random(job["seed"] + 1)))
    for user, beats in job["frames"]:
        source.send_nowait(AxiStreamFrame(tdata=beats, tuser=user))
    ended: list[bool] = []
    reader = cocotb.start_soon(keep_reading(manager, random.Random(job["seed"]), ended))
    back = [frame async for frame in received(dut, sink, job["expected"], job["silence"])]
    ended.append(True)
    await reader
    states = {name: await read(manager, address) for name, address in STATES.items()}
    Path("outcome.json").write_text(json.dumps({"back": back, "states": states}))


async def received(dut: Any, sink: Any, expected: int, silence: int) -> Any:
    """Frames as they come back, ``[tuser, words, cycle of the last word]``, until none comes for ``silence`` cycles.

    More than the ``expected`` ones come after a shorter time, if at all.
    """
    count, quiet = 0, 0
    while quiet < (silence if count < expected else 2000):
        if sink.empty():
            await ClockCycles(dut.aclk, 50)
            quiet += 50
            continue
        frame, quiet, count = sink.recv_nowait(), 0, count + 1
        user = frame.tuser[-1] if isinstance(frame.tuser, list) else frame.tuser
        yield [int(user), [int(word) for word in frame.tdata], round(frame.sim_time_end / PERIOD)]


def pauses(rng: random.Random) -> Iterator[bool]:
    """Pauses of every density, in bursts, and none, by turns."""
    while True:
        share, burst = rng.choice([0.0, 0.3, 0.8, 0.5]), rng.choice([1, 1, 20])
        for _ in range(rng.randint(20, 400) // burst):
            yield from [rng.random() < share] * burst


async def load(manager: Any, coefficients: list[int]) -> None:
    """Load a core as software does."""
    words = [word & 0xFFFFFFFF for word in coefficients]
    await write(manager, LOAD_CHECKSUM, zlib.crc32(b"".join(word.to_bytes(4, "little") for word in words)))
    for word in words:
        await write(manager, LOAD_DATA, word)


async def keep_reading(manager: Any, rng: random.Random, ended: list[bool]) -> None:
    """Registers are read until the frames have ended, and nothing changes by that."""
    while not ended:
        await read(manager, rng.choice(list(STATES.values())))


async def write(manager: Any, address: int, word: int) -> None:
    await manager.write(address, word.to_bytes(4, "little"))


async def read(manager: Any, address: int) -> int:
    return int.from_bytes((await manager.read(address, 4)).data, "little")


def main(simulator: str, top: str, folder: Path) -> None:
    """Compile and run; raises ``SystemExit`` or ``RuntimeError`` for what fails."""
    sources: list[Any] = sorted(folder.glob("*.v"))
    if simulator == "verilator":
        (folder / "visible.vlt").write_text(public_signals(top, ()))
        sources.append(VerilatorControlFile(folder / "visible.vlt"))
    runner = get_runner(simulator)
    places: dict[str, Any] = {"build_dir": folder, "hdl_toplevel": top}
    runner.build(sources=sources, build_args=BUILD_ARGUMENTS[simulator], timescale=TIMESCALE, always=True, **places)
    runner.test(test_module="bench.exactness.axi_play", hdl_toplevel_lang="verilog", test_dir=folder, **places)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
