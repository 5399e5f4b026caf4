"""The smallest core that is fast enough: kind, lanes and words from bounds on time, as FINN's ``target_fps``."""

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from heapq import heappop, heappush

from tfra.families import Family, Target, parts
from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.model.choices import SERIAL, VECTOR_WORDS, Architecture, Images
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of
from tfra.synth.candidates import Bounds, Candidate, Sizing, Speed
from tfra.synth.cell_count import cell_counts
from tfra.synth.clocks import clock_of
from tfra.synth.estimate import Counts, Estimate, estimate, misfits


def size_parts(array: Design | Skin, bounds: Bounds, advance: Callable[[int, int], None]) -> list[Sizing]:
    """:func:`size` for every part at its slowest grade; ``advance`` gets 1 after each of so many.

    A core that several parts have is elaborated once.
    """
    counts, found, targets = cache(cell_counts), [], parts()
    for target in targets:
        found.append(size(array, target, bounds, counts))
        advance(1, len(targets))
    return found


def size(array: Design | Skin, target: Target, bounds: Bounds, counts: Counts = cell_counts) -> Sizing:
    """Find the core of fewest lookup tables that meets ``bounds`` and fits ``target``; ignores CONFIG's architecture.

    That of a skin's window is chosen by the speed and the size of the whole skin.

    The serial core and each ``vector_words`` form a line of cores.  In a line, more lanes take more multipliers and
    lookup tables, except for those with coefficients: memories become shallower with more lanes, and may move into or
    out of block memories, with their registers.  So the first fast enough core of a line gives a lower bound on the
    resources of all that follow, and a line continues only while the part has these, and their lookup tables are below
    those of the best core.  More lanes are not always faster, so the speed of every core is computed.

    Raises ``ValueError`` for words that can overflow in every core.
    """
    design = core_of(array)
    made_of = cells(design, target.family)
    first = [design.built_as(Architecture(4, words), target=made_of) for words in VECTOR_WORDS]
    parallel = [_line(microarchitecture(one), array, target, bounds, counts) for one in first]
    seen: list[Candidate] = []
    waiting: list[tuple[int, int, Candidate, Iterator[Candidate]]] = []
    best = sys.maxsize

    def go_on(line: Iterator[Candidate]) -> None:
        for candidate in line:
            seen.append(candidate)
            if candidate.resources:
                heappush(waiting, (candidate.least["LUT"], len(seen), candidate, line))
                return

    for line in (_serial(array, target, bounds, counts), *parallel):
        go_on(line)
    while waiting and waiting[0][0] < best:
        _, _, candidate, line = heappop(waiting)
        if not candidate.objections:
            best = min(best, candidate.luts)
        if candidate.least["LUT"] < best and not _hopeless(candidate, target):
            go_on(line)
    serial_lacks: tuple[str, ...] = ()
    if best == sys.maxsize and (slow := seen[0]).design and not slow.resources:
        _, serial_lacks = _fitted(slow.design, array, target, counts)
    return Sizing(design, target, bounds, tuple(seen), serial_lacks)


def _hopeless(candidate: Candidate, target: Target) -> bool:
    """Whether cores with more lanes also lack multipliers, or tables or memories without coefficients."""
    lacks = misfits(candidate.least, target, candidate.architecture.kind, doubtful=True)
    return any(lack.startswith(("LUT:", "DSP:", "BRAM:")) for lack in lacks)


def _serial(array: Design | Skin, target: Target, bounds: Bounds, counts: Counts) -> Iterator[Candidate]:
    """The serial core, whose memories are always loaded, or the reason why it can't be built."""
    design = core_of(array)
    images: Images = "inline" if design.images == "load" else design.images
    try:
        core = microarchitecture(design.built_as(SERIAL, images=images, target=cells(design, target.family)))
        core.check()
    except ValueError as error:
        return iter([Candidate(SERIAL, None, None, None, (str(error),))])
    return _line(core, array, target, bounds, counts)


def cells(design: Design, family: Family) -> str:
    """``target.name`` of a core on ``family``: CONFIG's, if the part has its cells, else plain Verilog.

    Large memories that exist only as cells must be instantiated by name.
    """
    if "store" in family.gateware:
        return family.name
    return design.target if design.target == family.name else "portable"


def _line(
    first: Microarchitecture, array: Design | Skin, target: Target, bounds: Bounds, counts: Counts
) -> Iterator[Candidate]:
    """Cores with increasing lanes; only fast enough ones are elaborated."""
    clock_mhz = bounds.clock_mhz or clock_of(first.design.architecture.kind, target).mhz
    for core in first.choices():
        design, speed = core.design, Speed.of(core, clock_mhz, array)
        if missed := speed.misses(bounds):
            yield Candidate(design.architecture, design, speed, None, missed)
        else:
            found, lacks = _fitted(design, array, target, counts)
            yield Candidate(design.architecture, design, speed, found.total, lacks, found.least)


def _fitted(design: Design, array: Design | Skin, target: Target, counts: Counts) -> tuple[Estimate, tuple[str, ...]]:
    """The estimate of the core of ``design``, behind a skin if ``array`` is one, and what ``target`` lacks for it."""
    whole = replace(array, window=design) if isinstance(array, Skin) else design
    found = estimate(whole, target.family, counts=counts)
    return found, tuple(misfits(found.total, target, design.architecture.kind, doubtful=True))
