"""Assembler: quads from beats, those of forces between those of vectors."""

import random

import pytest

from tests.hdl.parallel.designs import label
from tests.hdl.parallel.tfra.combine.designs import DESIGNS, beats, words
from tfra.hdl.parallel.tfra.combine.assembler import Assembler
from tfra.hdl.parallel.tfra.combine.stages import Job
from tfra.sim.harness import play

WATCHED = ["vector.valid", "vector.payload.words", "vector.payload.force", "forces.valid", "forces.payload"]


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_quads_leave_a_cycle_behind_their_last_beat(design):
    rng = random.Random(9)
    jobs = {"forces": [Job.FORCE] * 3, "vector": [Job.E0, Job.E1, Job.D]}
    quads = {port: [words(rng, design.widths.vector, 4) for _ in range(3 * design.quads)] for port in jobs}
    waiting = {port: list(enumerate(beats(design, rows))) for port, rows in quads.items()}
    in_vector, cycles, ends = design.quads * design.cycles_per_quad, [], {port: [] for port in jobs}
    while any(waiting.values()):
        port = rng.choice([*jobs, None])
        if port is None or not waiting[port]:
            cycles.append({"sum": words(rng, design.widths.vector, design.architecture.vector_words)})
            continue
        count, row = waiting[port].pop(0)
        vector, number = divmod(count, in_vector)
        tag = {"job": jobs[port][vector], "place": 0, "number": number, "swap": 0, "scalar": 0}
        if number % design.cycles_per_quad == design.cycles_per_quad - 1:
            ends[port].append(len(cycles))
        cycles.append({"valid": 1, "tag": tag, "sum": row})
    seen = play(Assembler(design), [*cycles, {}], WATCHED)
    for port, payload in (("vector", "vector.payload.words"), ("forces", "forces.payload")):
        sent = [cycle for cycle, row in enumerate(seen) if row[f"{port}.valid"]]
        assert sent == [cycle + 1 for cycle in ends[port]]
        assert [seen[cycle][payload] for cycle in sent] == quads[port]
    force = [row["vector.payload.force"] for row in seen if row["vector.valid"]]
    assert force == [0] * 2 * design.quads + [1] * design.quads
