"""Everything around a core, with a simple core inside: frames, errors, resets, load, times; what cores promise it."""

import random
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.hdl.ip.harness import Bench
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.framer import HEADER_WORDS
from tfra.hdl.ip.output_stage import CUT
from tfra.hdl.ip.wrapper import cut_through, interval, latencies
from tfra.model.choices import SERIAL, Architecture, Bus, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status
from tfra.sim.harness import play


def design(taxels_per_beat: int = 1) -> TfraDesign:
    sensor = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
    return TfraDesign(sensor, "small", search=Search(3), architecture=Architecture(4), bus=Bus(taxels_per_beat))


def packed(taxels: list[int], per_beat: int) -> list[int]:
    """Beats of a frame; places that are left have ones."""
    filled = [taxel & 0xFFFF for taxel in taxels] + [0xFFFF] * (-len(taxels) % per_beat)
    groups = [filled[n : n + per_beat] for n in range(0, len(filled), per_beat)]
    return [sum(word << (16 * place) for place, word in enumerate(group)) for group in groups]


FRAME = [7, -3, 4, 100, -200, 5]


@pytest.mark.parametrize(("per_beat", "cut_through"), [(4, 1), *long((1, 0), (1, 1), (2, 0), (2, 1), (4, 0))])
def test_frames_of_all_lengths(per_beat: int, cut_through: int) -> None:
    bench = Bench(design(per_beat))
    rng = random.Random(per_beat)
    expected, dropped, whole = [], {"short": 0, "long": 0}, len(packed(FRAME, per_beat))

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1, cut_through=cut_through)
        for sequence in range(20):
            first, length = rng.randint(-8000, 8000), rng.choice([whole, whole, 1, rng.randint(1, 3 * whole)])
            beats = (packed([first, *FRAME[1:]], per_beat) * 3)[:length]
            await bench.send(ctx, beats, sequence + 1000, stalls=rng)
            if length == whole:
                expected.append((0, bench.answer(first, sequence, sequence + 1000, frame=len(expected))))
            else:
                dropped["short" if length < whole else "long"] += 1
        await bench.settle(ctx, 200)
        assert (await bench.read(ctx, "FRAMES_IN"))["count"] == len(expected)
        assert (await bench.read(ctx, "FRAMES_OUT"))["count"] == len(expected)
        assert (await bench.read(ctx, "FRAMES_DROPPED"))["count"] == sum(dropped.values())
        errors = await bench.read(ctx, "ERRORS")
        assert (errors["short_frame"], errors["long_frame"]) == (dropped["short"] > 0, dropped["long"] > 0)
        assert (await bench.read(ctx, "STATUS"))["busy"] == 0

    bench.run(host, rng=random.Random(5))
    assert bench.back == expected
    assert min(dropped.values()) > 0


@pytest.mark.parametrize("per_beat", [2, *long(1, 4)])
def test_latency(per_beat: int) -> None:
    bench = Bench(design(per_beat))

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        await bench.send(ctx, packed(FRAME, per_beat))
        await bench.settle(ctx)
        cycles = (await bench.read(ctx, "FRAME_CYCLES"))["cycles"]
        assert cycles == bench.given[-1] - bench.taken[0] - (per_beat > 1)

    bench.run(host)
    core = microarchitecture(bench.design)
    own = 1  # of the simple core, from its last taxel to its first word
    assert bench.given[2] - bench.taken[-1] == latencies(core)[0] - core.latency + own


CORES = [
    *long((replace(design(), architecture=SERIAL, bus=Bus(2)), 4, 1), (design(), 20, 0)),
    *long((learned_design(2, 3, (3, 2)), 20, 1), (learned_design(7, 7, (1, 1), lanes=64), 24, 0)),
]


@pytest.mark.parametrize(("built", "frames", "cut"), CORES, ids=["serial", "parallel", "learned", "output"])
def test_latencies_of_cores(built: Design, frames: int, cut: int) -> None:
    """From a frame's last beat to its first and last result word: a frame that is alone, and frames back to back."""
    core, taxels = microarchitecture(built), (FRAME * 9)[: built.sensor.taxels]
    load = core.loaded.ravel().tolist() if core.loaded is not None else []
    beats = packed(taxels, built.bus.taxels_per_beat)
    bench = Bench(built, len(load), core=core.build())

    async def host(ctx: Any) -> None:
        for word in load:
            await bench.write(ctx, "LOAD_DATA", word=word & 0xFFFFFFFF)
        await bench.write(ctx, "CONTROL", run=1, cut_through=cut)
        for number in range(1 + frames):
            await bench.send(ctx, beats)
            if not number:
                await bench.settle(ctx, 2 * core.frame_latency)
        while len(bench.back) <= frames:
            await ctx.tick()

    bench.run(host)
    given = np.array(bench.given).reshape(1 + frames, -1)
    found = given[:, [2, -1]] - np.array(bench.taken[len(beats) - 1 :: len(beats)])[:, None]
    idle, most = np.reshape(latencies(core), (2, 2))
    assert found[0].tolist() == list(cut_through(core) if cut else idle)
    if frames and cut:
        assert (found <= most).all()
    elif frames:
        assert set(most - found.max(axis=0)) <= {*range(HEADER_WORDS + 1)}
        late = interval(core) - core.initiation_interval
        assert set(np.diff(given[2:, -1])) >= {cycles + late for cycles in core.intervals}


def of_size(rows: int, columns: int) -> TfraDesign:
    return replace(design(2), sensor=SensorArray(rows, columns, 4e-3, 2e-3, 3e-3))


@pytest.mark.parametrize("built", [of_size(2, 3), *long(of_size(2, 2), of_size(2, 4), of_size(3, 3))], ids=str)
def test_no_frame_is_lost_while_results_wait(built: Design) -> None:
    """The core fills up, and the facts of all frames in it and in front of it wait, however small a frame is."""
    core, taxels, frames = microarchitecture(built), (FRAME * 2)[: built.sensor.taxels], 14
    bench = Bench(built, core=core.build(), open=False)

    async def opens(ctx: Any) -> None:
        await ctx.tick().repeat(frames * core.initiation_interval + core.frame_latency)
        bench.open = True

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        for number in range(frames):
            await bench.send(ctx, packed(taxels, built.bus.taxels_per_beat), number)
        await bench.settle(ctx, frames * core.initiation_interval + core.frame_latency)

    bench.run(host, opens)
    assert [words[0] >> 16 for _, words in bench.back] == [*range(frames)]


def test_counters_are_held_together() -> None:
    """At every phase of the frames that go on: what is read is of one cycle, and what came meanwhile is not lost."""
    bench = Bench(design())
    names = ("FRAMES_IN", "FRAMES_OUT", "FRAMES_DROPPED", "FRAME_CYCLES")
    cycles: list[list[int]] = []

    async def source(ctx: Any) -> None:
        for number in range(40):
            await bench.send(ctx, packed(FRAME, 1)[: 6 - (number % 4 == 3)])

    async def count(ctx: Any) -> None:
        control, now = bench.wrapper._control, [0] * 4
        seen = (control.events.accepted, control.ended, control.events.dropped, control.time - control.started)
        while True:
            _, _, *ups, taken = await ctx.tick().sample(*seen)
            now = [*(value + up for value, up in zip(now, ups, strict=False)), taken if ups[1] else now[3]]
            cycles.append(now)

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        for phase in range(24):
            await bench.settle(ctx, 1 + phase % 7)
            await bench.write(ctx, "CONTROL", run=1, hold_counters=1)
            found = [next(iter((await bench.read(ctx, name)).values())) for name in names]
            assert found in cycles
            await bench.write(ctx, "CONTROL", run=1)
        await bench.settle(ctx, 400)
        assert (await bench.read(ctx, "FRAMES_OUT"))["count"] == len(bench.back) == 30
        assert (await bench.read(ctx, "FRAMES_DROPPED"))["count"] == 10
        await bench.write(ctx, "CONTROL", run=1, clear_counters=1)
        assert [next(iter((await bench.read(ctx, name)).values())) for name in names] == [0] * 4

    bench.run(source, host, watch=[count])
    assert len({tuple(now) for now in cycles}) > 60


def test_forces_are_left_out_frame_by_frame() -> None:
    bench = Bench(design())

    async def host(ctx: Any) -> None:
        for forces in (1, 0, 1):
            await bench.write(ctx, "CONTROL", run=1, taxel_forces=forces)
            await bench.send(ctx, packed(FRAME, 1))
            await bench.settle(ctx)

    bench.run(host)
    assert bench.back == [(0, bench.answer(7, n, forces=n != 1)) for n in range(3)]


def test_soft_reset_in_frames() -> None:
    """A frame that comes in is skipped to its end; one that goes out is ended; a word on offer stays."""
    bench = Bench(design())

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        await bench.send(ctx, packed(FRAME, 1))
        await ctx.tick().until(bench.wrapper.results.valid)
        await bench.settle(ctx, 8)
        bench.open = False
        await bench.settle(ctx, 8)
        await bench.send(ctx, packed(FRAME, 1)[:4], last=False)
        offered = ctx.get(bench.wrapper.results.payload.data)
        await bench.write(ctx, "CONTROL", run=1, soft_reset=1)
        await bench.settle(ctx, 8)
        assert ctx.get(bench.wrapper.results.valid)
        assert ctx.get(bench.wrapper.results.payload.data) == offered
        bench.open = True
        await bench.send(ctx, [1, 2, 3])  # the rest of the frame that was cut, and more
        await bench.send(ctx, packed([50, *FRAME[1:]], 1), user=9)
        await bench.settle(ctx)
        assert (await bench.read(ctx, "FRAMES_OUT"))["count"] == 1
        assert (await bench.read(ctx, "FRAMES_DROPPED"))["count"] == 0
        assert not any((await bench.read(ctx, "ERRORS")).values())

    bench.run(host)
    (cut, words), whole = bench.back
    assert cut == 1
    assert words[:-1] == bench.answer(7, 0)[: len(words) - 1]
    assert whole == (0, bench.answer(50, 0, 9))


@pytest.mark.long
def test_soft_reset_at_every_phase_of_a_frame() -> None:
    """A frame leaves whole, ends with a word that no frame ends with, or leaves no word; the next one begins at 0."""
    bench, lengths = Bench(design()), set()

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        for phase in range(70):
            beats, whole, before = packed([phase, *FRAME[1:]], 1), bench.answer(phase, 0), len(bench.back)
            await bench.send(ctx, beats[: phase + 1], last=phase >= 5)
            await bench.settle(ctx, max(1, phase - 5))
            await bench.write(ctx, "CONTROL", run=1, soft_reset=1)
            await bench.send(ctx, beats[phase + 1 :])
            await bench.settle(ctx, 50)
            for cut, words in bench.back[before:]:
                lengths.add(len(words))
                assert words == ([*whole[: len(words) - 1], CUT] if cut else whole)
            assert len(bench.back) <= before + 1

    bench.run(host)
    assert lengths >= {*range(2, 1 + len(bench.answer(0, 0)))}
    assert len(bench.back) < 60


def test_run_stops_between_frames() -> None:
    bench = Bench(design())

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        await bench.send(ctx, packed(FRAME, 1)[:2], last=False)
        await bench.write(ctx, "CONTROL", run=0)
        await bench.settle(ctx, 50)
        assert (await bench.read(ctx, "STATUS"))["running"] == 1, "half of a frame is in"
        await bench.send(ctx, packed(FRAME, 1)[2:])
        ctx.set(bench.wrapper.frames.valid, 1)
        for _ in range(100):
            assert not ctx.get(bench.wrapper.frames.ready)
            await ctx.tick()
        assert (await bench.read(ctx, "STATUS"))["running"] == 0
        ctx.set(bench.wrapper.frames.valid, 0)
        await bench.write(ctx, "CONTROL", run=1)
        await bench.send(ctx, packed(FRAME, 1)[:2], last=False)
        await bench.write(ctx, "CONTROL", run=0, soft_reset=1)
        await bench.settle(ctx, 8)
        assert (await bench.read(ctx, "STATUS"))["running"] == 0, "the rest of the frame will be skipped"

    bench.run(host)
    assert bench.back == [(0, bench.answer(7, 0))]


@pytest.mark.parametrize("wrong", [0, *long(1)])
def test_load_at_the_rate_of_the_bus(wrong: int) -> None:
    words = [3, -5, 1 << 16, -1, 9]
    crc = zlib.crc32(b"".join((word & 0xFFFFFFFF).to_bytes(4, "little") for word in words))
    bench = Bench(design(), len(words))

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "LOAD_CHECKSUM", crc=crc ^ wrong)
        await bench.write(ctx, "CONTROL", run=1)
        assert (await bench.read(ctx, "STATUS"))["loaded"] == 0
        assert (await bench.read(ctx, "LOAD_STATUS"))["ready"] == 1
        for word in [*words, 77]:  # one more than it takes
            await bench.write(ctx, "LOAD_DATA", word=word & 0xFFFFFFFF)
        await bench.settle(ctx, 10)
        assert await bench.read(ctx, "LOAD_STATUS") == {"ready": 0, "match": 1 - wrong}
        assert (await bench.read(ctx, "LOAD_CRC"))["crc"] == crc
        assert (await bench.read(ctx, "LOAD_COUNT"))["words"] == len(words)
        assert (await bench.read(ctx, "ERRORS"))["load_checksum"] == wrong
        assert await bench.read(ctx, "INTERRUPT_STATUS") == {"error": wrong, "frame": 0, "loaded": 1}
        assert (await bench.read(ctx, "STATUS"))["loaded"] == 1
        await bench.send(ctx, packed(FRAME, 1))
        await bench.settle(ctx)
        await bench.write(ctx, "CONTROL", run=1, soft_reset=1)
        await bench.settle(ctx, 4)
        assert (await bench.read(ctx, "LOAD_CRC"))["crc"] == 0
        assert (await bench.read(ctx, "LOAD_COUNT"))["words"] == 0
        assert (await bench.read(ctx, "STATUS"))["loaded"] == 0

    bench.run(host)
    assert bench.back == [(0, bench.answer(7 + sum(words), 0))]


def test_stale_simulated_and_interrupts() -> None:
    bench = Bench(design())

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "INTERRUPT_ENABLE", error=1)
        await bench.write(ctx, "FRAME_TIMEOUT", cycles=120)
        await bench.settle(ctx, 200)
        assert not (await bench.read(ctx, "ERRORS"))["stale"], "it does not run"
        await bench.write(ctx, "CONTROL", run=1)
        await bench.settle(ctx, 90)
        await bench.send(ctx, packed(FRAME, 1))
        await bench.settle(ctx, 90)
        assert not (await bench.read(ctx, "ERRORS"))["stale"]
        assert not ctx.get(bench.wrapper.interrupt)
        await bench.settle(ctx, 100)
        assert (await bench.read(ctx, "ERRORS"))["stale"]
        assert ctx.get(bench.wrapper.interrupt)
        await bench.write(ctx, "FRAME_TIMEOUT", cycles=0)
        await bench.settle(ctx)
        await bench.write(ctx, "ERRORS", **dict.fromkeys(await bench.read(ctx, "ERRORS"), 1))
        await bench.write(ctx, "INTERRUPT_STATUS", error=1, frame=1)
        await bench.settle(ctx, 200)
        assert not ctx.get(bench.wrapper.interrupt)
        await bench.write(ctx, "CONTROL", run=1, simulate_error=1)
        await bench.settle(ctx, 4)
        assert ctx.get(bench.wrapper.interrupt)
        assert (await bench.read(ctx, "ERRORS"))["simulated"]
        await bench.send(ctx, packed(FRAME, 1))
        await bench.send(ctx, packed(FRAME, 1))
        await bench.settle(ctx, 200)
        assert (await bench.read(ctx, "INTERRUPT_STATUS"))["frame"]

    bench.run(host)
    assert bench.back == [(0, bench.answer(7, n, flags=(n == 1) << 7)) for n in range(3)]


def test_a_limited_result_is_in_the_status_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not in the frame's faults, which leave before."""
    monkeypatch.setattr("tests.hdl.ip.harness.STATUS", int(Status.OUTPUT_SATURATED))
    bench = Bench(design())

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        await bench.send(ctx, packed(FRAME, 1))
        await bench.settle(ctx)
        assert (await bench.read(ctx, "ERRORS"))["saturation"] == 1
        assert (await bench.read(ctx, "FRAMES_SATURATED"))["count"] == 1

    bench.run(host)
    assert bench.back == [(0, bench.answer(7, 0, flags=0))]


def test_the_last_faulty_taxel() -> None:
    bench = Bench(design())

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CONTROL", run=1)
        await bench.send(ctx, packed([*FRAME[:2], -8192, *FRAME[3:]], 1))
        await bench.settle(ctx)
        faulty = await bench.read(ctx, "FAULTY_TAXEL")
        assert faulty == {"index": 2, "saturated": 1, "out_of_range": 0, "stuck": 0}

    bench.run(host)


def test_calibration() -> None:
    """An offset is written, read back, applied, and its CRC is that of zlib."""
    bench = Bench(design())
    offset = 5 << 3  # 5 codes of 14 bits, in 1/2^17 of a range of 2^14

    async def host(ctx: Any) -> None:
        await bench.write(ctx, "CALIBRATION_PLACE", index=0, kind=0)
        await bench.write(ctx, "CALIBRATION_DATA", word=offset)
        await bench.settle(ctx, 8)
        crc = zlib.crc32(offset.to_bytes(4, "little"))
        assert (await bench.read(ctx, "CALIBRATION_CRC"))["crc"] == crc
        await bench.write(ctx, "CALIBRATION_PLACE", index=0, kind=0)
        await bench.settle(ctx, 8)
        assert (await bench.read(ctx, "CALIBRATION_VALUE"))["word"] == offset
        await bench.write(ctx, "CONTROL", run=1)
        await bench.send(ctx, packed(FRAME, 1))
        await bench.settle(ctx)

    bench.run(host, check=True)
    assert bench.back == [(0, bench.answer(7 - 5, 0))]


@pytest.mark.parametrize(("architecture", "images"), [(SERIAL, "inline"), *long((Architecture(4), "load"))])
def test_cores_take_a_coefficient_a_cycle_after_a_reset(architecture: Architecture, images: str) -> None:
    """So a word of LOAD_DATA never waits."""
    timing = microarchitecture(replace(design(), architecture=architecture, images=images))
    assert timing.loaded is not None
    cycles = [{"load.valid": 1, "load.payload": word} for word in (*timing.loaded.ravel().tolist(), 0)]
    ready = [row["load.ready"] for row in play(timing.build(), cycles, ["load.ready"])]
    assert ready == [1] * timing.loaded.size + [0]
