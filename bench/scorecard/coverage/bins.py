"""Declared bins: what the frames of a coverage run have to be, and the words that were compared in each."""

from collections import Counter
from itertools import product

import numpy as np

from bench.scorecard.words.harness import Configuration
from tfra.model.arrays import Bools, Ints
from tfra.model.cover.scenes import wild_codes
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.tfra.sweep import tolerance
from tfra.model.skin.skin import Skin
from tfra.model.tfra import Status

PARITIES = ("even", "odd")
STALLS = ("random", "bursts", "none")
"""As the kinds of ``Stalls`` in ``core.h``."""
PHASES = ("idle", "taxels come", "computing", "words leave")
"""Of a reset, as in ``sessions.cpp``."""
CORES = ("parallel tfra", "parallel learned", "serial tfra", "serial learned", "behind AXI", "skin")
PLATEAUS = ("one point", "several", "whole sweep", "a tie in B^xy, the first is taken")
POOL = 300_000
"""Taxels of the frames of which those are sent that show a status or a plateau."""
EACH = 3
"""Frames that are sent for each of these."""

_ALONE = {
    "tfra": TfraDesign.status_bits,
    "learned": LearnedDesign.status_bits,
}
_S = Status
_WITHOUT_OTHERS = (_S.NO_CONTACT, _S.COMPRESSION_ONLY)
_APART = {
    frozenset((_S.NO_CONTACT, _S.OUTPUT_SATURATED)),  # all results are zero
    frozenset((_S.VANISHING_DENOMINATOR, _S.DEPENDENT_OUT_OF_RANGE)),  # the dependent friction is set to zero
}
"""Pairs that exclude each other, beside those of the bits that say that nothing was calculated."""
UNSEEN = (
    _S.NO_DIRECTION | _S.VANISHING_DENOMINATOR,
    _S.NO_DIRECTION | _S.DEPENDENT_OUT_OF_RANGE,
    _S.VANISHING_DENOMINATOR | _S.OUTPUT_SATURATED,
)
"""Pairs of TFRA that are not declared: nothing excludes them, but none of 1,125,000 frames of noise shows them that are
the same on both sides of both axes, on arrays of 6, 8 and 12 taxels."""


def pairs(estimator: str) -> list[Status]:
    """Pairs of status bits that occur together in a frame."""
    bits, found = _ALONE[estimator], []
    for place, first in enumerate(bits):
        for second in bits[place + 1 :]:
            alone = first in _WITHOUT_OTHERS and second not in (_S.INPUT_SATURATED, _S.OUTPUT_SATURATED)
            excluded = alone or frozenset((first, second)) in _APART
            if not excluded and first | second not in UNSEEN:
                found.append(first | second)
    return found


def _told(status: Status) -> str:
    return " + ".join(str(bit.name) for bit in status)


def _alone(status: Status) -> str:
    return f"{status.name} alone" if status else "none"


def declared() -> list[str]:
    """All bins, crosses included: parities of both sides; core × stalls of both ports; core × phase of a reset."""
    return [
        *(f"array: {rows} rows, {columns} columns" for rows, columns in product(PARITIES, PARITIES)),
        *(f"lanes: {lanes}" for lanes in ("4", "between", "all")),
        *(f"words a cycle: {words}" for words in (1, 2, 4)),
        *(f"coefficients: {kind}" for kind in ("inline", "load")),
        *(f"axi: {kind}" for kind in ("whole frames", "cut through")),
        *(f"stalls: {core}, in {a}, out {b}" for core, a, b in product(CORES, STALLS, STALLS)),
        *(f"reset: {core}, {phase}" for core, phase in product(CORES, PHASES)),
        *(f"plateau: {kind}" for kind in ("none", *PLATEAUS)),
        *(f"status: {one}, {_alone(bit)}" for one, bits in _ALONE.items() for bit in (Status(0), *bits)),
        *(f"status: {one}, {_told(pair)}" for one in _ALONE for pair in pairs(one)),
    ]


def core(configuration: Configuration) -> str:
    """The kind of a core among ``CORES``."""
    if configuration.wrapped:
        return "behind AXI"
    design = configuration.design
    skin = isinstance(configuration.array, Skin)
    return "skin" if skin else f"{design.architecture.kind} {design.estimator}"


def pool(configuration: Configuration, seed: int) -> Ints:
    """Noise ``(n, rows, columns)``: half of any codes; a quarter has the same on both sides of both axes, so that it
    has no direction; a quarter has few values, up to the ends of the range, so that sums often cancel.  Frames whose
    taxels are all pressed alike, by any power of two, are between.
    """
    count, rng = POOL // configuration.design.sensor.taxels, np.random.default_rng(seed)
    codes, quarter = wild_codes(configuration.design, count, seed), count // 4
    rows, columns = codes.shape[1:]
    half = codes[:quarter]
    half = np.where(np.arange(rows)[:, None] < rows / 2, half, half[:, ::-1])
    codes[:quarter] = np.where(np.arange(columns) < columns / 2, half, half[:, :, ::-1])
    bits = configuration.design.adc.bits
    codes[quarter : quarter + bits] = (-1 << np.arange(bits))[:, None, None]
    few = rng.integers(-4, 5, (quarter, rows, columns)) << rng.integers(0, bits - 2, (quarter, 1, 1))
    codes[-quarter:] = np.minimum(few, (1 << (bits - 1)) - 1)
    return codes


def plateaus(design: TfraDesign, codes: Ints) -> dict[str, Bools]:
    """Which of ``codes (n, rows, columns)`` have each kind of plateau."""
    kinds: dict[str, list[Bools]] = {kind: [] for kind in ("none", *PLATEAUS)}
    for trace in FixedTfra(design).traces(codes):
        swept, frame = trace.swept, trace.frame
        inside = swept.b_z <= (swept.b_z.min(axis=1) + tolerance(design)[frame.exponent])[:, None]
        least = np.where(inside, swept.b_xy, np.iinfo(np.int64).max)
        tie = (least == least.min(axis=1)[:, None]).sum(axis=1) > 1
        count, some = inside.sum(axis=1), frame.regular
        whole = count == design.candidates
        found = (count == 1, (count > 1) & ~whole, whole & (count > 1), tie & (count > 1))
        kinds["none"].append(~some)
        for kind, these in zip(PLATEAUS, found, strict=True):
            kinds[kind].append(some & these)
    return {kind: np.concatenate(parts) for kind, parts in kinds.items()}


def kinds_of(configuration: Configuration, codes: Ints) -> dict[str, Bools]:
    """Which of ``codes (n, rows, columns)`` are in each bin of status and plateau; none for a skin."""
    if isinstance(configuration.array, Skin):
        return {}
    design = configuration.design
    status = design.model(codes).words[:, -1]
    one = design.estimator
    found = {f"status: {one}, {_alone(bit)}": status == bit for bit in (Status(0), *_ALONE[one])}
    found |= {f"status: {one}, {_told(pair)}": status & pair == pair for pair in pairs(one)}
    if isinstance(design, TfraDesign):
        found |= {f"plateau: {kind}": these for kind, these in plateaus(design, codes).items()}
    return found


def chosen(configuration: Configuration, seed: int) -> Ints:
    """Frames ``(n, rows, columns)`` of the pool, some of each bin that it has."""
    if isinstance(configuration.array, Skin):
        return np.zeros((0, configuration.array.sensor.rows, configuration.array.sensor.columns), dtype=np.int64)
    codes = pool(configuration, seed)
    places = [np.flatnonzero(these)[:EACH] for these in kinds_of(configuration, codes).values()]
    return codes[np.unique(np.concatenate(places))]


def hit(configuration: Configuration, given: Ints, counts: dict[str, list[int]]) -> Counter[str]:
    """Words (of statuses and plateaus: frames) that were compared in each bin; ``counts`` are those of the program."""
    design, kind, sensor = configuration.design, core(configuration), configuration.array.sensor
    words = sum(counts["stalled"])
    bins = [f"array: {PARITIES[sensor.rows % 2]} rows, {PARITIES[sensor.columns % 2]} columns"]
    if design.architecture.kind == "parallel":
        lanes = design.architecture.mac_lanes
        bins += [f"words a cycle: {design.architecture.vector_words}"]
        bins += ["lanes: 4"] * (lanes == 4) + ["lanes: all"] * (lanes == 4 * design.quads)
        bins += ["lanes: between"] * (4 < lanes < 4 * design.quads)
    bins.append(f"coefficients: {design.images}")
    if configuration.wrapped:
        bins.append(f"axi: {'cut through' if configuration.cut_through else 'whole frames'}")
    found = Counter(dict.fromkeys(bins, words))
    for number, count in enumerate(counts["stalled"]):
        found[f"stalls: {kind}, in {STALLS[number % 3]}, out {STALLS[number // 3]}"] += count
    for phase, count in zip(PHASES, counts["after"], strict=True):
        found[f"reset: {kind}, {phase}"] += count
    found.update({name: int(these.sum()) for name, these in kinds_of(configuration, given).items()})
    return found
