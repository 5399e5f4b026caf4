"""Sizing against a full enumeration: every number of lanes, words and kind, each elaborated and estimated."""

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest

from tests.marks import long
from tfra.families import TARGETS, Family, find
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import FORMATS, SERIAL, VECTOR_WORDS, Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth import size as module
from tfra.synth.candidates import Bounds, Candidate, Sizing, Speed
from tfra.synth.clocks import clock_of
from tfra.synth.estimate import Estimate, estimate, misfits
from tfra.synth.size import cells, size, size_parts


def design(rows: int, columns: int, **others: Any) -> Design:
    return TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), **{"architecture": Architecture(4), **others})


SUBJECTS = {
    "2x2": design(2, 2, search=Search(10)),
    "2x4": design(2, 4, search=Search(10)),
    "3x4": design(3, 4, search=Search(12)),
    "4x4 cells": design(4, 4, target="ecp5", search=Search(20)),
    "3x4 asked for as serial": design(3, 4, architecture=SERIAL, search=Search(12)),
    "3x3 loaded": design(3, 3, images="load", formats=Formats("custom", 14, 16, 5, 3)),
    "5x5": design(5, 5, adc=Adc(12)),
    "6x6 wide": design(6, 6, formats=FORMATS["wide"], search=Search(50)),
    "8x8 cells": design(8, 8, target="ecp5", adc=Adc(12), formats=Formats("custom", 14, 14, 5, 3)),
    "10x10": design(10, 10),
}

Core = tuple[Architecture, Speed, Estimate]


@cache
def enumerated(name: str, family: str) -> list[Core]:
    """Every core that can be built of the subject's sensor for parts of ``family``, asked one by one."""
    part = next(target for target in TARGETS.values() if target.family.name == family)
    subject, found = SUBJECTS[name], []
    made_of = family if family == "ice40" or subject.target == family else "portable"
    lanes = range(4, 4 * subject.quads + 1, 4)
    for architecture in (SERIAL, *(Architecture(number, words) for number in lanes for words in VECTOR_WORDS)):
        images = "inline" if architecture == SERIAL else subject.images
        one = replace(subject, architecture=architecture, images=images, target=made_of)
        core = microarchitecture(one)
        speed = Speed(core.initiation_interval, core.frame_latency, clock_of(architecture.kind, part).mhz)
        found.append((architecture, speed, estimate(one, part.family)))
    return found


def smallest(name: str, part: str, bounds: Bounds) -> int | None:
    """Lookup tables of the smallest core that meets ``bounds`` and fits, by looking at all of them."""
    target = find(part)
    return min(
        (
            used["LUT"]
            for architecture, speed, found in enumerated(name, target.family.name)
            for used in [found.total]
            if 1e6 * speed.clock_mhz / speed.interval >= bounds.frames_per_second
            and speed.frame_latency / speed.clock_mhz <= bounds.latency_us
            and not misfits(used, target, architecture.kind, doubtful=True)
        ),
        default=None,
    )


def refusal(found: Sizing) -> str:
    """Why there is no core."""
    with pytest.raises(ValueError, match=" ") as error:
        _ = found.chosen
    return str(error.value)


QUESTIONS = [
    *long(
        ("2x2", "ecp5-25", 3e5, 1e4),
        ("2x4", "ecp5-25", 1e5, 5.2),
        ("2x2", "ice40up5k", 1e3, 1e4),
        ("2x2", "ecp5-25", 1e9, 1e4),
        ("3x4", "ecp5-25", 6e5, 1e3),
        ("3x4 asked for as serial", "ice40up5k", 100, 1e5),
        ("4x4 cells", "ecp5-45", 5e5, 1e4),
        ("3x3 loaded", "ecp5-25", 100, 1e5),
        ("3x3 loaded", "ecp5-25", 3e5, 1e4),
        ("3x4", "gw2a-18", 2.5e5, 1e4),
        ("3x4", "xc7", 1e3, 500.0),
    ),
]


@pytest.mark.parametrize(("name", "part", "fps", "latency"), QUESTIONS)
def test_the_smallest_of_all(name: str, part: str, fps: float, latency: float) -> None:
    target = find(part)
    bounds = Bounds(None, fps, latency)
    found, least = size(SUBJECTS[name], target, bounds), smallest(name, part, bounds)
    if least is None:
        assert refusal(found)
        return
    cores = {architecture: (speed, used) for architecture, speed, used in enumerated(name, target.family.name)}
    assert found.chosen.luts == least
    for candidate in found.candidates:
        speed, used = cores[candidate.architecture]
        assert candidate.speed == speed
        assert candidate.resources in (None, used.total)
    assert {each.line for each, _ in found.others} | {found.chosen.line} == {
        ("serial", 0),
        *(("parallel", words) for words in VECTOR_WORDS),
    }


@pytest.mark.long
def test_a_wrong_price_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The enumeration does not follow the search: a core whose estimate goes wrong in it alone is not the smallest."""
    bounds = Bounds(None, 1e5, 1e4)
    least = smallest("2x2", "ecp5-25", bounds)

    def wrong(one: Design, family: Family, **_: object) -> SimpleNamespace:
        total = estimate(one, family).total
        total["LUT"] *= 4 if one.architecture.vector_words == 1 else 1
        return SimpleNamespace(total=total, least=total)

    monkeypatch.setattr(module, "estimate", wrong)
    assert size(SUBJECTS["2x2"], find("ecp5-25"), bounds).chosen.luts != least


LINES = [("3x4", "gatemate"), ("3x4", "gowin"), ("3x4", "xilinx"), ("4x4 cells", "ecp5"), ("3x4", "ice40")]


@pytest.mark.parametrize(("name", "family"), [("2x2", "ecp5"), *long(*LINES)])
def test_more_lanes_take_more(name: str, family: str) -> None:
    """Of multipliers and, without coefficients, of lookup tables and memories: so the search knows what is left."""
    for words in VECTOR_WORDS:
        line = [used for architecture, _, used in enumerated(name, family) if architecture.vector_words == words]
        assert len(line) == SUBJECTS[name].quads
        for fewer, more in pairwise(line):
            assert fewer.least["LUT"] < more.least["LUT"]
            assert fewer.least["BRAM"] <= more.least["BRAM"]
            assert "DSP" not in fewer.total or fewer.total["DSP"] < more.total["DSP"]


@pytest.mark.parametrize("name", long("2x4", "5x5", "6x6 wide"))
def test_lanes_that_share_their_blocks(name: str) -> None:
    """Cycles of a core among the choices are those of the core alone; more lanes are not always faster."""
    for words in VECTOR_WORDS:
        first = microarchitecture(replace(SUBJECTS[name], architecture=Architecture(4, words)))
        found = list(first.choices())
        assert tuple(core.lanes for core in found) == first.lane_choices
        for core in found:
            alone = microarchitecture(replace(SUBJECTS[name], architecture=Architecture(core.lanes, words)))
            assert Speed.of(core, 98.0) == Speed.of(alone, 98.0)
        if (name, words) == ("5x5", 1):  # as docs/synth.md has it
            intervals = {core.lanes: core.initiation_interval for core in found}
            assert (intervals[20], intervals[32]) == (369, 448)
    serial = microarchitecture(SUBJECTS["3x4 asked for as serial"])
    assert list(serial.choices()) == [serial]


@pytest.fixture
def cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    """Prices without elaborating any core: 100 lookup tables a lane, 10 a word, and block memories that lanes share."""

    def cost(one: Design, family: object, **_: object) -> SimpleNamespace:
        lanes = one.architecture.mac_lanes or 100  # the serial core is the largest
        luts = 100 * lanes + 10 * one.architecture.vector_words
        total = {"LUT": luts, "FF": 1, "DSP": 1, "BRAM": 40 // lanes, "SPRAM": 0}
        return SimpleNamespace(total=total, least={**total, "BRAM": 0})

    monkeypatch.setattr(module, "estimate", cost)


BEST = r"[\d.]+ is the best, at 100 MHz \(parallel, 16 lanes, 4 words\)"
LEAST = r"for the smallest core that is fast enough \(parallel, 4 lanes, 1 word\)"
FITS = r"the serial core fits: [\d,.]+ frames/s, [\d,.]+ us to the last word"
OVER = r"the serial core does not fit: LUT: about 10,000 are needed, tiny has \d+"
NEEDED = "are needed, ice40up5k has"
EASY = Bounds(100.0, 1.0, 1e6)


@pytest.mark.parametrize(
    ("bounds", "available", "said"),
    [
        (Bounds(100.0, 1e9, 1e3), {}, rf"frames_per_second: 1e\+09 are wanted, {BEST}; {FITS}"),
        (Bounds(100.0, 1.0, 0.1), {}, rf"latency_us: 0.1 is wanted, {BEST}; {FITS}"),
        (EASY, {"LUT": 90, "DSP": 1}, f"LUT: about 410 are needed, tiny has 90, {LEAST}; {OVER}"),
        (EASY, {"LUT": 500, "BRAM": 5}, f"BRAM: about 10 are needed, tiny has 5, {LEAST}; {OVER}"),
        (Bounds(100.0, 1e5, 1e4), {"LUT": 300}, f"LUT: about 410 are needed, tiny has 300, {LEAST}; {OVER}"),
    ],
)
def test_bounds_and_parts_out_of_reach(cheap: None, bounds: Bounds, available: dict[str, int], said: str) -> None:
    found = size(SUBJECTS["3x4"], replace(find("ecp5-85"), name="tiny", available=available), bounds)
    assert re.fullmatch(said, refusal(found))
    assert available or len(found.candidates) == 13


@pytest.mark.parametrize(
    ("used", "said"),
    [
        ({"BRAM": 30}, ""),
        (
            {"BRAM": 32, "DSP": 9},
            "DSP: about 9 are needed, ice40up5k has 8; BRAM: about 32 are needed, ice40up5k has 30",
        ),
        ({"LUT": 5070}, ""),
        ({"LUT": 5080}, "LUT: about 5,080, at most 5,284, are needed, ice40up5k has 5,280"),
    ],
)
def test_never_a_core_that_may_not_fit(monkeypatch: pytest.MonkeyPatch, used: dict[str, int], said: str) -> None:
    """Estimates of lookup tables of serial cores are up to 4.0 % short; those of block memories never are."""

    def cost(one: Design, family: object, **_: object) -> SimpleNamespace:
        total = {"LUT": 100, "FF": 1, "DSP": 8, "BRAM": 1, "SPRAM": 4, **used}
        total["LUT"] *= 100 if one.architecture.mac_lanes else 1
        return SimpleNamespace(total=total, least=total)

    monkeypatch.setattr(module, "estimate", cost)
    found = size(SUBJECTS["2x2"], find("ice40up5k"), Bounds(30.0, 1.0, 1e6))
    if said:
        assert refusal(found) == f"{said}, for the smallest core that is fast enough (serial)"
    else:
        assert found.chosen.title == "serial"


def test_each_bound_by_another_core() -> None:
    """One core has the frames, another one the latency: the line names both."""
    bounds = Bounds(100.0, 1e5, 20.0)
    pairs = [(Architecture(8, 1), Speed(900, 2100, 100.0)), (Architecture(12, 1), Speed(1100, 1900, 100.0))]
    pairs.append((SERIAL, Speed(20_000, 19_000, 50.0)))
    seen = tuple(Candidate(core, None, speed, None, speed.misses(bounds)) for core, speed in pairs)
    assert refusal(Sizing(SUBJECTS["3x4"], find("ecp5-85"), bounds, seen)) == (
        "frames_per_second, latency_us: no core reaches both: parallel, 8 lanes, 1 word reaches 111111.1 "
        "frames/s at 100 MHz, parallel, 12 lanes, 1 word 19.000 us at 100 MHz; "
        "the serial core fits: 2,500.0 frames/s, 380.000 us to the last word"
    )


def test_every_part_once(cheap: None) -> None:
    """Each as if asked for alone, at its slowest grade."""
    told: list[tuple[int, int]] = []
    found = size_parts(SUBJECTS["2x2"], EASY, lambda *counts: told.append(counts))
    names = ["ecp5-25-6", "ecp5-45-6", "ecp5-85-6", "ice40up5k", "gw2a-18", "xc7", "gatemate-a1"]
    assert [each.target.name for each in found] == names
    assert told == [(1, len(names))] * len(names)
    alone = size(SUBJECTS["2x2"], find("ice40up5k"), EASY)
    assert (found[3].chosen.architecture, found[3].others) == (alone.chosen.architecture, alone.others)


def test_more_lanes_for_fewer_memories(cheap: None) -> None:
    shallow = replace(find("ecp5-85"), available={"LUT": 1000, "BRAM": 5})
    assert size(SUBJECTS["3x4"], shallow, EASY).chosen.architecture == Architecture(8, 1)


@pytest.mark.parametrize(
    ("subject", "said"),
    [
        (
            design(3, 4, formats=Formats("custom", 18, 18, 9, 4, (("operand.normal", 16),))),
            "formats.signals.operand.normal: a serial core has one multiplier",
        ),
        *long((design(24, 24), "architecture.kind: the serial core holds 2048 words, more are needed")),
    ],
)
def test_where_the_serial_core_cannot_be(cheap: None, subject: Design, said: str) -> None:
    """It has no word lengths of single signals, and its memories hold no large array."""
    found = size(subject, find("ecp5-85"), EASY)
    (serial,) = (each for each in found.candidates if each.title == "serial")
    assert serial.speed is None
    assert serial.objections[0].startswith(said)
    assert found.chosen.architecture == Architecture(4, 1)
    assert [why for each, why in found.others if each is serial] == [serial.objections[0]]


def test_a_serial_core_is_never_inside_an_image(cheap: None) -> None:
    """Where CONFIG's images are loaded, those of a serial core's program are not."""
    candidates = size(SUBJECTS["3x3 loaded"], find("ecp5-85"), EASY).candidates
    (serial,) = (each for each in candidates if each.title == "serial")
    assert serial.design
    assert serial.design.images == "inline"
    assert all(each.design and each.design.images == "load" for each in candidates if each is not serial)


@pytest.mark.parametrize(
    ("asked", "part", "made_of"),
    [
        ("portable", "ecp5-25", "portable"),
        ("ecp5", "ecp5-25", "ecp5"),
        ("ice40", "ecp5-25", "portable"),
        ("ecp5", "xc7", "portable"),
        ("portable", "ice40up5k", "ice40"),
        ("ecp5", "ice40up5k", "ice40"),
    ],
)
def test_cells_of_the_part(asked: str, part: str, made_of: str) -> None:
    assert cells(design(2, 2, target=asked), find(part).family) == made_of


def test_misses_in_words() -> None:
    found = Speed(interval=1000, frame_latency=2000, clock_mhz=100.0)
    assert found.misses(Bounds(100.0, 1e5, 20.0)) == ()
    assert found.misses(Bounds(100.0, 100001, 19.9)) == (
        "too slow: 100,000.0 frames/s, 100,001 are wanted",
        "too late: 20.000 us to the last word, 19.9 is wanted",
    )
