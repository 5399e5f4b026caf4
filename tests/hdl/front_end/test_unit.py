"""The front end gives the codes, flags and faulty taxels of the model, whatever comes and however it comes."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from tests.hdl.front_end.session import Frame, Seen, Session, words
from tests.marks import long
from tfra.hdl.front_end.calibrate import GAINS, OFFSETS, REPAIRS
from tfra.hdl.front_end.repair import Repair
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
    used = np.array(repairs[: rng.integers(0, len(repairs) + 1)], dtype=np.int64)
    return Tables(offsets, gains.astype(np.int64), used)


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
    return frames


def play(design: Design, seed: int, stall_in=flowing, stall_out=flowing, count: int = 5) -> tuple[Seen, Expected]:
    """Random settings, tables, frames, tares and resets; frames are cut through in half of the sessions."""
    rng = np.random.default_rng(seed)
    unit = FrontEnd(design)
    session, expected = Session(unit, stall_in=stall_in, stall_out=stall_out, seed=seed), Expected(design)
    for _ in range(2):
        settings = any_settings(rng, design)
        tables = any_tables(rng, design)
        cut_through = int(rng.integers(2))
        if cut_through:
            settings, tables = replace(settings, contact=0), replace(tables, repairs=np.zeros(0, dtype=np.int64))
        expected.unit.settings, expected.unit.tables = settings, tables
        session.set(settings, tables, cut_through=cut_through)
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


@pytest.mark.parametrize("seed", [*range(4), *long(*range(4, 60))])
def test_random_sessions(seed):
    design = make(*SIZES[seed % 4], bits=8 + seed % 9)
    stalls = [(flowing, flowing), (random_stalls, flowing), (flowing, random_stalls), (bursts, bursts)]
    compare(*play(design, seed, *stalls[(seed // 4 + seed) % 4]), seed)


def transparent(design: Design, unit: FrontEnd | None = None, **more: int) -> Session:
    session = Session(unit or FrontEnd(design))
    session.set(Settings(design.adc.bits), **more)
    return session


def numbered(count: int, taxels: int = 6, first: int = 0) -> list[Frame]:
    """Frames of different words."""
    rng = np.random.default_rng(count)
    return [Frame(words(rng.integers(-8000, 8000, taxels)), first + number) for number in range(count)]


def signed(frames: list[Frame]) -> list[list[int]]:
    return [np.array(frame.words, dtype=np.uint16).astype(np.int16).tolist() for frame in frames]


@pytest.mark.parametrize(("size", "repairs"), [((2, 2), 1), ((2, 3), 0), ((2, 3), 2), *long(((5, 5), 0), ((5, 5), 2))])
def test_cycles_are_the_promised_ones(size, repairs):
    """Of frames with a pause between them, and without; a taxel a cycle."""
    design = make(*size)
    m = design.sensor.taxels
    terms = [HEADER | 1 << PLACE, ONE - 1, 2 << PLACE | 7] * repairs
    tables = Tables(np.zeros(m, np.int64), np.full(m, 32768), np.array(terms, dtype=np.int64))
    unit = FrontEnd(design)
    session = Session(unit)
    session.set(Settings(14), tables)
    for frame in numbered(3, m):
        session.frames(frame)
        session.check("busy", 0)
    session.frames(*numbered(9, m))
    seen = session.play()
    last, first = np.array(seen.taken[m - 1 :: m]), np.array(seen.given[::m])
    late = Repair.cycles(len(terms), repairs)
    assert (first - last)[:3].tolist() == [unit.latency + late] * 3
    assert (np.array(seen.given[m - 1 :: m]) - first == m - 1).all(), "a code a cycle"
    assert (np.diff(seen.taken[:m]) == 1).all(), "a taxel a cycle"
    assert np.diff(first[-4:]).max() <= unit.interval(len(terms), repairs)


def test_a_contact_at_the_last_taxel_alone_is_one():
    """The smallest array leaves the least time between its last code and the first one that leaves."""
    session = transparent(make(2, 2), contact=100)
    session.frames(Frame([1, 2, 3, 100]), Frame([1, 2, 3, 99]))
    assert session.play().codes == [[1, 2, 3, 100], [0, 0, 0, 0]]


@pytest.mark.parametrize("size", [(2, 2), (3, 5)])
def test_cut_through_takes_the_promised_cycles(size):
    """From each taxel to its code, and no more for frames without a pause between them."""
    design = make(*size)
    unit, m = FrontEnd(design), design.sensor.taxels
    session = transparent(design, unit, cut_through=1)
    frames = numbered(4, m)
    for frame in frames[:2]:
        session.frames(frame)
        session.check("busy", 0)
    session.frames(*frames[2:])
    seen = session.play()
    assert seen.codes == signed(frames)
    assert set(np.subtract(seen.given, seen.taken)[: 3 * m]) == {unit.cut_through}


@pytest.mark.parametrize("stall", [flowing, random_stalls, bursts])
def test_bad_frames_that_are_cut_through_end_in_zeros(stall):
    frames = numbered(8)
    cut = [Frame(frames[1].words[:2], 1), Frame(frames[2].words[:5], 2), Frame(frames[3].words * 3, 3)]
    session = Session(FrontEnd(make()), stall_out=stall)
    session.set(Settings(14, log2_tare=0), cut_through=1)
    session.frames(frames[0], *cut, *frames[4:6])
    session.pulse("tare")
    session.frames(Frame([0] * 6, 6), frames[7])
    seen = session.play()
    assert seen.codes == signed([frames[0], *frames[4:6], frames[7]])
    for codes, (begun, length) in zip(seen.bad, zip(signed(frames[1:4]), (2, 5, 6), strict=True), strict=True):
        assert codes[length:] == [0] * (6 - length)
        assert all(each in (0, code) for each, code in zip(codes, begun, strict=True))
    assert seen.events == {"accepted": 5, "dropped": 3, "short_frame": 2, "long_frame": 1}


def test_a_frame_of_one_taxel_is_not_cut_through():
    frames = numbered(3)
    session = transparent(make(), cut_through=1)
    session.frames(frames[0], *[Frame([5], 1)] * 3, *frames[1:])
    seen = session.play()
    assert (seen.codes, seen.bad) == (signed(frames), [])


@pytest.mark.parametrize("more", [{"contact": 1}, {"repair_words": 2}])
def test_frames_wait_for_what_needs_the_whole_of_them(more):
    """From the first frame after a reset on."""
    session = transparent(make(), cut_through=1, **more)
    session.reset(skip=False)
    session.frames(*numbered(2), Frame([1, 2, 3], 2))
    seen = session.play()
    assert seen.bad == []
    assert (np.array(seen.given[::6]) > seen.taken[5:12:6]).all()


def test_a_frame_that_goes_on_or_ends_early_leaves_no_trace():
    frames = numbered(6)
    short, long_one = Frame(frames[1].words[:5], 1), Frame(frames[2].words * 3, 2)
    session = transparent(make(), check_sequence=1, stuck_frames=2)
    session.frames(frames[0], short, long_one, Frame(frames[0].words[:1], 3), *frames[4:])
    seen = session.play()
    assert seen.codes == signed([frames[0], *frames[4:]])
    assert [each["sequence"] for each in seen.facts] == [0, 4, 5]
    assert seen.events == {"accepted": 3, "dropped": 3, "short_frame": 2, "long_frame": 1}


@pytest.mark.parametrize(("taken", "skip"), [(1, True), (3, True), (5, True), (2, False)])
def test_the_rest_of_a_frame_that_a_reset_cut_is_skipped_on_demand(taken, skip):
    frames = numbered(3)
    session = transparent(make())
    session.frames(Frame(frames[0].words[:taken], ends=False))
    session.reset(skip=skip, drained=False)
    session.frames(Frame(frames[0].words[taken:] if skip else frames[0].words), *frames[1:])
    seen = session.play()
    assert seen.codes == signed(frames[skip:])
    assert [each["sequence"] for each in seen.facts] == list(range(3 - skip))
    assert seen.events == {"accepted": 3 - skip}


def test_a_tare_that_a_reset_cuts_leaves_the_offsets():
    design = make()
    tables = Tables(np.arange(6) * 8, np.full(6, 32768), np.zeros(0, np.int64))
    session = Session(FrontEnd(design))
    session.set(Settings(14, log2_tare=0), tables)
    session.pulse("tare")
    session.frames(Frame(words([999] * 5), ends=False))
    session.reset(skip=True, drained=False)
    frame = Frame(words([100] * 6))
    session.frames(Frame(words([999])), frame)
    assert session.play().codes == [(100 - np.arange(6)).tolist()]


def test_a_tare_becomes_the_offsets_that_software_reads():
    session = transparent(make(), log2_tare=1)
    session.pulse("tare")
    session.check("taring", 1)
    session.frames(Frame(words([1, 2, 3, -4, 5, 6])), Frame(words([2, 2, 3, -5, 5, 8])))
    session.check("taring", 0)
    for place in range(6):
        session.read(OFFSETS, place)
        session.read(GAINS, place)
    session.read(REPAIRS, 0)
    session.frames(Frame(words([2, 2, 2, 2, 2, 2])))
    seen = session.play()
    offsets = [12, 16, 24, -36, 40, 56]  # 1/8 of a code each
    assert seen.values == [value % (1 << 32) for o in offsets for value in (o, 32768)] + [0]
    assert seen.codes == [[1, 0, -1, 7, -3, -5]]  # halves go up


def test_late_frames_are_dropped_whole_or_wait():
    """The core takes nothing: with drop_late, two frames wait and the others are dropped."""

    def never(rng):
        yield from [True] * 400
        while True:
            yield False

    frames = numbered(5)
    for drop in (0, 1):
        session = Session(FrontEnd(make()), stall_out=never)
        session.set(Settings(14), drop_late=drop)
        session.frames(*frames)
        seen = session.play()
        assert seen.codes == signed(frames[: 2 if drop else 5])
        assert seen.events["input_overflow"] == seen.events["dropped"] == 3 * drop
        assert (seen.taken[-1] < 100) == bool(drop)


@pytest.mark.parametrize("cycles", [12, 24, 50])
def test_repairs_end_when_fewer_words_are_used_in_mid_frame(cycles):
    design = make()
    words = [HEADER | 1 << PLACE, *[2 << PLACE | 7] * 39]
    unit = FrontEnd(design)
    session = Session(unit)
    session.set(Settings(14), Tables(np.zeros(6, np.int64), np.full(6, 32768), np.array(words)))
    session.frames(*numbered(1))
    session.change(cycles, repair_words=3)
    session.check("busy", 0)
    for place in range(40):
        session.read(REPAIRS, place)
    session.frames(*numbered(1))
    seen = session.play()
    assert seen.values == words
    late = np.array(seen.given[::6]) - seen.taken[5::6]
    assert late[0] <= unit.latency + Repair.cycles(len(words), 1)
    assert late[1] == unit.latency + Repair.cycles(3, 1)


@pytest.mark.parametrize("stall", [flowing, random_stalls])
def test_taxels_that_can_not_wait_go_before_repairs(stall):
    """A frame comes while the one before is being repaired: neither waits for the other's products for long."""
    design = make(3, 5)
    m = design.sensor.taxels
    rng = np.random.default_rng(5)
    terms = [k << PLACE | 9000 + k for k in (0, 1, 2, 14)]
    table = [HEADER | 3 << PLACE, *terms, HEADER | 14 << PLACE, 3 << PLACE | ONE]
    tables = Tables(np.zeros(m, np.int64), rng.integers(1, 1 << 17, m), np.array(table * 3))
    session, expected = Session(FrontEnd(design), stall_in=stall), Expected(design)
    expected.unit.tables = tables
    session.set(Settings(14), tables, drop_late=1)
    for frames in (numbered(2, m), numbered(2, m, 2), numbered(2, m, 4)):
        session.frames(*frames)
        session.check("busy", 0)
        expected.frames(frames)
    seen = session.play()
    compare(seen, expected)
    if stall is flowing:
        assert (np.diff(seen.taken)[: 2 * m - 1] == 1).all()


def test_a_simulated_error_is_in_the_next_frame_alone():
    session = transparent(make(), log2_average=1)
    session.frames(*numbered(2))
    session.check("busy", 0)
    session.pulse("simulate")
    session.frames(*numbered(4))
    assert [each["flags"]["simulated"] for each in session.play().facts] == [0, 1, 0]


@pytest.mark.parametrize("bits", [6, 7, 17])
def test_other_converters_are_refused(bits):
    with pytest.raises(ValueError, match=rf"^adc.bits: 8 to 16 are supported with the front end, got {bits}$"):
        FrontEnd(make(bits=bits))


def test_a_corrupted_value_is_noticed():
    original, expected = play(make(), 3, count=4)
    compare(original, expected)
    corruptions = {
        "codes": lambda seen: seen.codes[-1].__setitem__(2, seen.codes[-1][2] ^ 1),
        "facts": lambda seen: seen.facts[0]["flags"].__setitem__("stuck", 1 - seen.facts[0]["flags"]["stuck"]),
        "events": lambda seen: seen.events.update(["saturation"]),
        "faulty taxels": lambda seen: seen.faulty[-1].__setitem__("index", 63),
    }
    for name, corrupt in corruptions.items():
        seen = deepcopy(original)
        corrupt(seen)
        with pytest.raises(AssertionError, match=f"{name} differ"):
            compare(seen, expected)
