"""Line 8: faults of the sensor, of its stream and of the calibration, planted in front of a core behind AXI."""

import tempfile
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.exactness.designs import untrained
from bench.publish import ROOT, insert
from bench.scorecard.faults import host
from bench.scorecard.faults.player import ERRORS, SOFT_RESET, Heard, Player, read, running, settings, wait, write
from bench.scorecard.faults.streams import (
    EVERY,
    FAULTS,
    JITTER,
    LAST,
    NOISE,
    PEAK,
    TIMEOUT,
    Stream,
    clean,
    planted,
    stuck_frames,
)
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from tfra.codegen.config.read import load
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.choices import Adc, Architecture
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import GAIN, UNITY
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status

SEED = 1
CLEAN, PIECE = 1_000_000, 50_000
"""Clean frames, and those of a run of the simulator."""
PLANTED, QUICK_PLANTED, QUICK_CLEAN = 100, 10, 5_000
"""Faults of each class; a quarter of them in the larger array."""
PAGE, MARK = "docs/front_end.md", "faults"


def threshold(bits: int) -> int:
    """The least codes of a contact: eight times the noise."""
    return int(np.ceil(8 * NOISE[1] * 2 ** (bits - 1)))


def small() -> Design:
    """4×4 taxels with a converter of 12 bits and a core of any weights, which takes few cycles."""
    choices: dict[str, Any] = {"adc": Adc(12, contact_threshold=threshold(12)), "architecture": Architecture(16)}
    return untrained(4, 4, (6, 4), images="load", taxel_forces=False, **choices)


def trained() -> Design:
    """10×10 taxels with trained weights, which say what is implausible."""
    design = load(ROOT / "examples" / "learned_resultant.toml").design
    return replace(design, adc=replace(design.adc, contact_threshold=threshold(design.adc.bits)))


def limited(least: int | None, frames: int) -> int:
    """Clean frames of TFRA whose result is limited, by the bit-accurate model; ``least`` codes are a contact."""
    adc, sensor = Adc(12, contact_threshold=least), SensorArray(4, 4, 4e-3, 2e-3, 3e-3)
    design = TfraDesign(sensor, adc=adc, architecture=Architecture(16))
    stream = clean(design, frames, 100, np.random.default_rng(SEED))
    return int((design.model(stream.words.reshape(-1, 4, 4)).words[:, -1] & Status.OUTPUT_SATURATED != 0).sum())


@dataclass(eq=False)
class Bench:
    """A core that runs, with ``stuck`` for STUCK.frames; ``rng`` draws the streams.

    ``doubts``: its weights are trained, and its status bit IMPLAUSIBLE means something.
    """

    player: Player
    stuck: int
    rng: np.random.Generator
    check_sequence: bool = True
    doubts: bool = False

    @property
    def design(self) -> Design:
        """That of the core."""
        return self.player.design

    @property
    def period(self) -> int:
        """Cycles from frame to frame: a tenth more than the core needs; a frame comes in a quarter of them."""
        return max(round(1.1 * microarchitecture(self.design).initiation_interval), 4 * self.design.sensor.taxels + 40)

    def stream(self, count: int) -> Stream:
        """So many clean frames."""
        return clean(self.design, count, self.period, self.rng)

    def hear(self, *script: Ints) -> Heard:
        """Load the core, start it, and play ``script`` and a time in which all results come."""
        told = settings(self.stuck, round(TIMEOUT * self.period), self.check_sequence)
        ended = [write("CONTROL", 0), wait(20 * microarchitecture(self.design).frame_latency)]
        return self.player.play(np.concatenate([*self.load(self.player.coefficients), told, *script, *ended]))

    def load(self, words: Ints) -> list[Ints]:
        """The script that loads ``words``; the checksum is that of the right ones."""
        if not len(words):
            return []
        crc = zlib.crc32(self.player.coefficients.astype("<i4").tobytes())
        return [write("LOAD_CHECKSUM", crc), write("LOAD_DATA", *words.tolist())]


def alarms(bench: Bench, frames: int) -> dict[str, int]:
    """Slots with an alarm in so many clean ``frames``, frames without a result, and the alarms by name."""
    found: Counter[str] = Counter(frames=frames, false=0, missing=0)
    for first in range(0, frames, PIECE):
        count = min(PIECE, frames - first)
        heard = bench.hear(bench.stream(count).script())
        found.update(names(heard.alarms | heard.errors))
        found["false"] += int((heard.alarms | heard.errors != 0).sum())
        found["missing"] += count - int((heard.status >= 0).sum())
        progress(f"{first + count:,} clean frames: {dict(found)}")
    return dict(found)


def names(bits: Ints) -> Iterator[str]:
    """The names of the ``bits (n,)`` of ERRORS."""
    for value in bits[bits != 0].tolist():
        yield from (name for place, name in enumerate(ERRORS) if value >> place & 1)


def told(heard: Heard, at: Ints, taxels: Ints | None = None) -> dict[str, Any]:
    """How faults from the slots ``at`` on were told: in their frame, later or never, by what, and with their taxel."""
    delays, by, named = [], Counter[str](), 0
    for number, slot in enumerate(at.tolist()):
        seen = np.flatnonzero(heard.alarms[slot : slot + LAST + 4])
        if not len(seen):
            continue
        delays.append(int(seen[0]))
        by.update(names(heard.alarms[slot + seen[:1]]))
        named += taxels is not None and int(heard.faulty[slot + seen[0]] & 0xFFFF) == int(taxels[number])
    later = [delay for delay in delays if delay]
    record: dict[str, Any] = {"planted": len(at), "at_once": len(delays) - len(later), "later": len(later)}
    record |= {"never": len(at) - len(delays), "by": dict(by.most_common()), "named": named}
    return record | ({"median": float(np.median(later)), "most": max(later)} if later else {})


def implausible(heard: Heard, at: Ints) -> float:
    """Share of the frames with a contact from ``at`` on, as long as a fault lasts, that the estimator doubts."""
    status = np.concatenate([heard.status[slot : slot + LAST] for slot in at.tolist()])
    status = status[(status >= 0) & (status & Status.NO_CONTACT == 0)]
    return round(float((status & Status.IMPLAUSIBLE != 0).mean()), 3) if len(status) else 0.0


def judged(bench: Bench, heard: Heard, at: Ints, taxels: Ints | None = None) -> dict[str, Any]:
    """The record of a class."""
    record = told(heard, at, taxels)
    return record | ({} if not bench.doubts else {"implausible": implausible(heard, at)})


def of_stream(bench: Bench, name: str, count: int) -> dict[str, Any]:
    """Faults ``name`` of the sensor or its stream, or none."""
    stream = bench.stream(EVERY * (count + 2))
    at, taxels = planted(stream, FAULTS.get(name), bench.rng)
    return judged(bench, bench.hear(stream.script()), at, taxels)


def wrong_tables(bench: Bench, count: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Tables that are wrong when they are written, with the right checksum, until they are mended."""
    m, bits, share = bench.design.sensor.taxels, bench.design.adc.bits, round(host.OFFSET * 2**16)

    def one(kind: int, value: int) -> tuple[Ints, Ints]:
        place, right = int(bench.rng.integers(m)) | kind << 16, UNITY * kind
        return _table(place, [value]), _table(place, [right])

    def every() -> tuple[Ints, Ints]:
        return _table(0, bench.rng.integers(-share, share + 1, m).tolist()), _table(0, [0] * m)

    kinds = {
        "gain of a taxel 0": lambda: one(1, 0),
        "gain of a taxel twice": lambda: one(1, 2 * UNITY),
        "gain of a taxel half": lambda: one(1, UNITY // 2),
        "sign of all taxels": lambda: (write("FRONT_END", bits | 1 << 6), write("FRONT_END", bits)),
        "offset of a taxel": lambda: one(0, share),
        "offsets of all taxels": every,
    }
    stop = [write("CONTROL", 0), wait(4 * microarchitecture(bench.design).frame_latency)]
    for name, draw in kinds.items():
        stream, parts = bench.stream(EVERY * count), []
        for first in range(0, EVERY * count, EVERY):
            (bad, good), middle = draw(), first + EVERY - LAST
            parts += [stream.script(first, middle), *stop, bad, running(bench.check_sequence)]
            parts += [stream.script(middle, first + EVERY), *stop, good, running(bench.check_sequence)]
        at = (EVERY + 2) * np.arange(count) + EVERY - LAST + 1
        yield name, judged(bench, bench.hear(*parts), at)


def _table(place: int, words: list[int]) -> Ints:
    return np.concatenate([write("CALIBRATION_PLACE", place), write("CALIBRATION_DATA", *words)])


def damaged_words(bench: Bench, count: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Words with a wrong bit on their way into the core, which no frame has to wait for."""
    rng, m = bench.rng, bench.design.sensor.taxels
    parts, sums = [write("CONTROL", 0)], []
    for _ in range(count):
        words = rng.integers(1 << GAIN, size=m)
        sums.append(zlib.crc32(words.astype("<u4").tobytes()))
        parts += [_table(int(rng.integers(2)) << 16, _damaged(words, rng).tolist()), read("CALIBRATION_CRC")]
    differ = int((bench.hear(*parts).values != sums).sum())
    yield "bit of a table's word wrong", _before(count, differ, "CALIBRATION_CRC")
    if len(right := bench.player.coefficients):
        parts = []
        for _ in range(count):
            parts += [write("CONTROL", SOFT_RESET), *bench.load(_damaged(right, rng)), wait(50)]
        heard = bench.hear(*parts)
        yield "bit of a coefficient wrong", _before(count, list(names(heard.errors)).count("load_checksum"), ERRORS[6])


def _damaged(words: Ints, rng: np.random.Generator) -> Ints:
    changed = words.copy()
    changed[rng.integers(len(words))] ^= 1 << int(rng.integers(32))
    return changed


def _before(count: int, told: int, by: str) -> dict[str, Any]:
    """The record of what is told before the first frame."""
    return {"planted": count, "at_once": told, "later": 0, "never": count - told, "by": {by: told}, "named": 0}


def array(design: Design, count: int, frames: int, doubts: bool = False) -> dict[str, Any]:
    """All classes in front of ``design``, ``count`` faults of each, and clean ``frames``; ``doubts`` as in Bench."""
    words = max(frames, CLEAN) * design.sensor.taxels
    stuck = stuck_frames(NOISE[0] * 2 ** (design.adc.bits - 1), words)
    rng = np.random.default_rng([SEED, design.sensor.taxels])
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Player(design, Path(folder)), stuck, rng, doubts=doubts)
        record: dict[str, Any] = {
            "array": f"{design.sensor.rows}×{design.sensor.columns}",
            "settings": {
                "STUCK.frames": stuck, "FRAME_TIMEOUT": round(TIMEOUT * bench.period), "CONTROL.check_sequence": 1,
                "contact_threshold_codes": design.adc.threshold, "cycles from frame to frame": bench.period,
            },
            "clean": alarms(bench, frames),
            "classes": {"none": of_stream(bench, "none", count)},
        }  # fmt: skip
        for name in FAULTS:
            record["classes"][name] = of_stream(bench, name, count)
            progress(f"{record['array']} {name}: {record['classes'][name]}")
        for name, found in (*wrong_tables(bench, count), *damaged_words(bench, count)):
            record["classes"][name] = found
            progress(f"{record['array']} {name}: {found}")
    return record


def measure(quick: bool) -> Measured:
    """A small array; and a larger one, with trained weights, unless it has to be ``quick``."""
    count = QUICK_PLANTED if quick else PLANTED
    records = [array(small(), count, QUICK_CLEAN if quick else CLEAN)]
    if not quick:
        records.append(array(trained(), count // 4, QUICK_CLEAN, doubts=True))
    by_host = host.told(trained(), 4 if quick else host.BLOCKS, SEED)
    classes = joined(records)
    if not quick:
        insert(MARK, table(classes, by_host), PAGE)
    none = classes.pop("none")
    missed = [name for name, one in classes.items() if one["at_once"] < one["planted"]]
    frames = sum(record["clean"]["frames"] for record in records)
    false = sum(record["clean"]["false"] + record["clean"]["missing"] for record in records)
    false += none["planted"] - none["never"]
    figure = f"{len(classes) - len(missed)} of {len(classes)} classes are told within a frame"
    later = sum(not classes[name]["never"] for name in missed)
    figure += f", {later} later, {len(missed) - later} not or not always; {false:,} false alarms in {frames:,} frames"
    facts = {"seed": SEED, "noise": NOISE, "peaks": PEAK, "stuck_frames": thresholds(), "arrays": records}
    facts["limited results of TFRA by threshold, in 5,000"] = {str(t): limited(t, 5000) for t in (None, threshold(12))}
    return Measured(figure, not missed and not false, facts | {"host": by_host, "missed": missed})


def thresholds() -> dict[str, int]:
    """STUCK.frames by the noise of a taxel in codes, for 0.01 false alarms in all clean words of 16 taxels."""
    return {str(sigma): stuck_frames(sigma, 16 * CLEAN) for sigma in (0.3, 0.5, 1.0, 2.0, 6.0)}


def joined(records: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """The classes of all arrays together."""
    found: dict[str, dict[str, Any]] = {}
    for name, one in ((name, one) for record in records for name, one in record["classes"].items()):
        sums = found.setdefault(name, {"by": Counter(), **dict.fromkeys(("planted", "at_once", "later", "never"), 0)})
        for key in ("planted", "at_once", "later", "never"):
            sums[key] += one[key]
        sums["by"] += Counter(one["by"])
        sums["most"] = max(sums.get("most", 0), one.get("most", 0))
        sums["implausible"] = one.get("implausible", sums.get("implausible"))
    return found


def table(classes: dict[str, dict[str, Any]], by_host: dict[str, dict[str, Any]]) -> str:
    """Markdown: a row for each class."""
    lines = [
        "| fault | planted | in its frame | later, after up to | never | by | implausible | warned of |",
        "|---|---:|---:|---:|---:|---|---:|---:|",
    ]
    for name, one in classes.items():
        by = ", ".join(f"`{word}`" for word in one["by"])
        later = f"{_share(one, 'later')}, {one['most']}" if one["later"] else "–"
        doubt = "–" if one["implausible"] is None else f"{100 * one['implausible']:.0f} %"
        warned = f"{100 * by_host[name]['told'] / by_host[name]['blocks']:.0f} %" if name in by_host else "–"
        cells = name, one["planted"], _share(one, "at_once"), later, _share(one, "never"), by, doubt, warned
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def _share(one: dict[str, Any], key: str) -> str:
    return f"{100 * one[key] / one['planted']:.0f} %"


LINE = Line(
    8,
    "faults of sensor and streams that are told",
    "each class within a frame, 0 false alarms in 1e6 clean frames",
    "faults are planted singly, at random; clean frames are simulated presses with Gaussian noise of"
    f" {100 * NOISE[0]:g} to {100 * NOISE[1]:g} % of full scale, that come {100 * JITTER:g} % early or late at most.",
    (*GATEWARE, "recordings", "sim", "bench/exactness/axi.py", "bench/scorecard/words", "bench/scorecard/faults"),
    measure,
)
