"""Two implementations of a register map side by side in a Verilog simulator, driven by cocotbext-axi.

It plays the accesses of ``script.json`` on both and writes ``outcome.json``: how many answers were compared, and those
that differ.
"""

import itertools
import json
import random
from pathlib import Path
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, Combine, RisingEdge
from cocotbext.axi import AxiLiteBus, AxiLiteMaster

SIDES = ("ours", "etana")


@cocotb.test()
async def play(dut: Any) -> None:
    """Every access on both; answers and outputs after it, and the pulses at the end."""
    script = json.loads(Path("script.json").read_text())
    managers = [manager(dut, side) for side in SIDES]
    outputs = {name: [dut[f"{side}_{name}"] for side in SIDES] for name in script["outputs"]}
    pulses = {name: [0, 0] for name in script["pulses"]}
    await reset(dut, script["inputs"])
    for name, counts in pulses.items():
        for side in range(len(SIDES)):
            cocotb.start_soon(count(dut, dut[f"{SIDES[side]}_{name}"], counts, side))
    compared, differ = 0, []
    for access in script["accesses"]:
        results: list[Any] = [None, None]
        if access[0] == "happen":
            await happen(dut, *access[1:])
        else:
            await Combine(*(cocotb.start_soon(ask(managers[n], access, results, n)) for n in range(len(SIDES))))
        await ClockCycles(dut.clk, 4)
        states = {name: [int(port.value) for port in ports] for name, ports in outputs.items()}
        for name, pair in {"answer": results, **states}.items():
            compared += 1
            differ += [[access, name, *pair]] if pair[0] != pair[1] else []
    differ += [["at the end", name, *counts] for name, counts in pulses.items() if counts[0] != counts[1]]
    Path("outcome.json").write_text(json.dumps({"compared": compared, "pulses": pulses, "differ": differ}))


def manager(dut: Any, side: str) -> AxiLiteMaster:
    """A manager with stalls of its own on every channel."""
    made, rng = AxiLiteMaster(AxiLiteBus.from_prefix(dut, f"{side}_axil"), dut.clk, dut.rst), random.Random(side)
    stalls = [rng.random() < 0.3 for _ in range(997)]
    channels = [made.write_if.aw_channel, made.write_if.w_channel, made.write_if.b_channel]
    channels += [made.read_if.ar_channel, made.read_if.r_channel]
    for number, channel in enumerate(channels):
        channel.set_pause_generator(itertools.cycle(stalls[100 * number :] + stalls[: 100 * number]))
    return made


async def reset(dut: Any, inputs: list[str]) -> None:
    for name in inputs:
        dut[name].value = 0
    dut.rst.value = 1
    Clock(dut.clk, 10, unit="ns").start()
    await ClockCycles(dut.clk, 4)
    dut.rst.value = 0
    await ClockCycles(dut.clk, 2)


async def count(dut: Any, pulse: Any, counts: list[int], side: int) -> None:
    while True:
        await RisingEdge(dut.clk)
        counts[side] += int(pulse.value)


async def happen(dut: Any, values: dict[str, int], strobe: str) -> None:
    """Set inputs to ``values``, and the input ``strobe`` for one cycle if there is one."""
    for name, value in values.items():
        dut[name].value = value
    if strobe:
        dut[strobe].value = 1
        await RisingEdge(dut.clk)
        dut[strobe].value = 0


async def ask(manager: AxiLiteMaster, access: list[Any], results: list[Any], side: int) -> None:
    if access[0] == "read":
        answer = await manager.read(access[1], 4)
        results[side] = [int.from_bytes(answer.data, "little"), int(answer.resp)]
    else:
        results[side] = int((await manager.write(access[1], bytes(access[2]))).resp)
