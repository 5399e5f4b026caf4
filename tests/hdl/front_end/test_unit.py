"""The front end gives the codes, flags and faulty taxels of the model, whatever comes and however it comes."""

from __future__ import annotations

import random

import numpy as np
import pytest

from tests.hdl.front_end.bench import Frame, Seen, Session, words
from tests.marks import STALLS, long
from tfra.hdl.front_end.repair import Repair
from tfra.hdl.front_end.tables import GAINS, OFFSETS, REPAIRS
from tfra.hdl.front_end.unit import FrontEnd
from tfra.model.choices import Adc, Architecture
from tfra.model.fixed import front_end as model
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import Settings, Tables
from tfra.model.fixed.repair import HEADER, ONE, PLACE
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.sim.harness import bursts, flowing, random_stalls

NAMES = ("saturation", "out_of_range", "stuck", "sequence_gap")


def make(rows: int = 2, columns: int = 3, bits: int = 14, target: str = "portable") -> Design:
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    return TfraDesign(sensor, adc=Adc(bits), architecture=Architecture(4), target=target)


class Expected:
    """What the model makes of the steps of a session."""

    def __init__(self, design: Design) -> None:
        self.unit, self.sequence = model.FrontEnd(design), 0
        self.seen, self.taxels = Seen(), design.sensor.taxels

    def frames(self, frames: list[Frame]) -> None:
        whole = np.array([len(frame.words) == self.taxels for frame in frames], dtype=bool)
        raw = np.array([frame.words if good else [0] * self.taxels for frame, good in zip(frames, whole, strict=True)])
        found = self.unit(raw, [frame.user for frame in frames], whole)
        for number, last in enumerate(found.last):
            flags = {name: int(found.flags[name][number]) for name in NAMES} | {"simulated": 0}
            sequence, user = (self.sequence + int(last)) % 65536, frames[last].user
            self.seen.facts.append({"sequence": sequence, "user": user, "flags": flags})
            self.seen.codes.append(found.codes[number].ravel().tolist())
        self._events(frames, whole, found)
        self.sequence += len(frames)

    def reset(self) -> None:
        self.unit.reset()
        self.sequence = 0

    def _events(self, frames: list[Frame], whole: np.ndarray, found: model.Cleaned) -> None:
        counts = dict(zip(model.FAULTS, found.faults.any(axis=1).sum(axis=0).tolist(), strict=True))
        short = sum(len(frame.words) < self.taxels for frame in frames)
        counts |= {"accepted": int(whole.sum()), "dropped": int((~whole).sum()), "short_frame": short}
        counts |= {"long_frame": counts["dropped"] - short, "sequence_gap": int(found.gap.sum())}
        self.seen.events.update({name: count for name, count in counts.items() if count})
        for faults in found.faults[found.faults.any(axis=(1, 2))]:
            index = int(np.flatnonzero(faults.any(axis=1))[-1])
            saturated, out_of_range, stuck = map(int, faults[index])
            where = {"index": index, "saturated": saturated, "out_of_range": out_of_range, "stuck": stuck}
            self.seen.faulty.append(where)


def compare(seen: Seen, expected: Expected, seed: int = 0) -> None:
    facts = [{name: value for name, value in each.items() if name != "started"} for each in seen.facts]
    assert facts == expected.seen.facts, f"facts differ (seed {seed})"
    assert seen.codes == expected.seen.codes, f"codes differ (seed {seed})"
    assert seen.events == expected.seen.events, f"events differ (seed {seed})"
    assert seen.faulty == expected.seen.faulty, f"faulty taxels differ (seed {seed})"


def any_settings(rng: np.random.Generator, design: Design) -> Settings:
    top = 1 << (design.adc.bits - 1)
    return Settings(
        word_bits=int(rng.integers(8, 17)),
        is_unsigned=bool(rng.integers(2)),
        invert=bool(rng.integers(2)),
        log2_average=int(rng.choice([0, 0, 1, 2, 3])),
        log2_tare=int(rng.integers(0, 4)),
        dead_band=int(rng.choice([0, 1, top // 8, top])),
        contact=int(rng.choice([0, 0, top // 2, top])),
        stuck_frames=int(rng.choice([0, 1, 2, 3, 255])),
        check_sequence=bool(rng.integers(2)),
    )


def any_tables(rng: np.random.Generator, design: Design) -> Tables:
    taxels, half = design.sensor.taxels, 1 << 17
    offsets = rng.integers(-half, half, taxels) >> rng.integers(0, 18, taxels)
    gains = rng.choice([0, 1, 32768, 32767, 131071, 40000], taxels)
    repairs = [HEADER | int(t) << PLACE | int(w) for t, w in rng.integers(0, (taxels, ONE), (3, 2))]
    for _ in range(rng.integers(0, 12)):
        source = int(rng.integers(taxels)) << PLACE | int(rng.integers(1 << PLACE))
        repairs.insert(int(rng.integers(1, len(repairs) + 1)), source)
    return Tables(offsets, gains.astype(np.int64), np.array(repairs[: rng.integers(0, len(repairs) + 1)], dtype=np.int64))


def any_frames(rng: np.random.Generator, taxels: int, word_bits: int, count: int) -> list[Frame]:
    """Frames of random size and length; words repeat, are at ends of their range, or out of it."""
    frames: list[Frame] = []
    before, user = np.zeros(taxels, dtype=np.int64), int(rng.integers(1 << 16))
    for _ in range(count):
        fresh = rng.integers(-1 << (word_bits - 1), 1 << (word_bits - 1), taxels) >> rng.integers(0, word_bits)
        ends = rng.choice([0, -1, 1 << (word_bits - 1), (1 << (word_bits - 1)) - 1, (1 << word_bits) - 1], taxels)
        wild = rng.integers(0, 1 << 16, taxels)
        pick = rng.choice(4, taxels, p=rng.choice([[0.9, 0.04, 0.03, 0.03], [0.2, 0, 0, 0.8], [1, 0, 0, 0]]))
        before = np.choose(pick, [fresh, ends, wild, before]) & 0xFFFF
        user = (user + int(rng.choice([1, 1, 1, 1, 2, 0]))) % 65536
        length = int(rng.choice([taxels] * 6 + [1, taxels - 1, taxels + 1, 3 * taxels]))
        frames.append(Frame(np.resize(before, length).tolist(), user))
        if length != taxels:
            before = np.array(frames[-2].words[:taxels]) if len(frames) > 1 and len(frames[-2].words) == taxels else before
    return frames


def play(design: Design, seed: int, stall_in=flowing, stall_out=flowing, count: int = 8) -> tuple[Seen, Expected]:
    """Random settings, tables, frames, tares and resets."""
    rng = np.random.default_rng(seed)
    unit = FrontEnd(design)
    session, expected = Session(unit, stall_in=stall_in, stall_out=stall_out, seed=seed), Expected(design)
    for _ in range(2):
        settings = any_settings(rng, design)
        tables = any_tables(rng, design)
        expected.unit.settings, expected.unit.tables = settings, tables
        session.set(settings, tables)
        session.reset(skip=False)
        expected.reset()
        for what in rng.choice(["frames", "tare", "reset"], 4, p=[0.6, 0.2, 0.2]):
            if what == "tare":
                session.pulse("tare")
                expected.unit.tare()
            if what == "reset":
                session.reset(skip=False)
                expected.reset()
            frames = any_frames(rng, design.sensor.taxels, settings.word_bits, count)
            session.frames(*frames)
            expected.frames(frames)
    return session.play(), expected


SIZES = ((2, 2), (2, 3), (3, 3), (3, 5))


@pytest.mark.parametrize("seed", [*range(16), *long(*range(16, 200))])
def test_random_sessions(seed):
    design = make(*SIZES[seed % 4], bits=8 + seed % 9)
    stalls = [(flowing, flowing), (random_stalls, flowing), (flowing, random_stalls), (bursts, bursts)][seed // 4 % 4]
    compare(*play(design, seed, *stalls), seed)
