"""A block between registers: ports by name, the same words, and a table row for each."""

from __future__ import annotations

import numpy as np
from amaranth.sim import Simulator

from bench.parts.blocks import row
from bench.parts.flat import Flat
from tfra.hdl.parallel.tfra.blocks import Blocks
from tfra.hdl.parallel.tfra.weights import Weights
from tfra.model.choices import Architecture
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.weights import weights
from tfra.model.sensor import SensorArray

DESIGN = TfraDesign(SensorArray(2, 2, 4e-3, 2e-3, 3e-3), architecture=Architecture(4))


def test_ports_are_the_members_of_the_streams_but_for_constants() -> None:
    vector = 4 * DESIGN.widths.vector
    flat = {name: len(Flat(block).signature.members) for name, block in Blocks.of(DESIGN)}
    assert all(flat.values())
    ports = {name: member.shape for name, member in Flat(Weights(DESIGN)).signature.members.items()}
    assert (ports["solution_payload"], ports["solution_valid"], ports["frame_ready"]) == (vector, 1, 1)
    assert not {"solution_ready", "n_ready"} & set(ports)


def test_words_pass_as_they_do_without_it() -> None:
    flat, bits = Flat(Weights(DESIGN)), DESIGN.widths.vector
    solution = butterfly(np.array([[[900, -1000, 5, -77]]]))
    seen = []

    async def bench(ctx) -> None:  # type: ignore[no-untyped-def]
        facts = {"exponent": 0, "magnitude": 0, "contact": 1, "traction": 1, "saturated": 0}
        shape = Weights(DESIGN).frame.payload.shape()
        ctx.set(flat.frame_payload, shape.const(facts).as_value())
        ctx.set(flat.frame_valid, 1)
        words = solution[0, 0] & ((1 << bits) - 1)
        ctx.set(flat.solution_payload, sum(int(word) << (bits * place) for place, word in enumerate(words)))
        ctx.set(flat.solution_valid, 1)
        await ctx.tick()
        ctx.set(flat.solution_valid, 0)
        while not seen:
            _, _, valid, n = await ctx.tick().sample(flat.n_valid, flat.n_payload)
            if valid:
                seen.append(n)

    simulator = Simulator(flat)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
    want = weights(solution, np.array([True]))[0, 0] & ((1 << bits) - 1)
    assert seen == [sum(int(word) << (bits * place) for place, word in enumerate(want))]


def test_a_row_of_the_table() -> None:
    used = {"LUT": 1425, "FF": 437, "DSP": 1, "BRAM": 0}
    found = {"resources": used, "mhz": 131.9, "logic_ns": 2, "routing_ns": 5.58}
    assert row("friction", found) == "| `friction` | 1,425 | 437 | 1 | 0 | 131.9 | 2.0 | 5.6 |"
