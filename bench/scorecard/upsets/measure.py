"""Line 7: single bits of registers and memories flipped in the running core, and what comes of it."""

import re
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.exactness.designs import core, untrained
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from bench.scorecard.words.harness import Configuration, built, ran
from tfra.families.hierarchy import block_of
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import SERIAL, Adc, Architecture, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status
from tfra.study.errors.statistics import rate

SEED, QUICK_UPSETS, LEAST = 1, 3000, 100_000
UPSETS = {"parallel": 30_000, "serial": 7_000}
"""Upsets of a core: enough for each of its registers, and for ``LEAST`` of all."""
FRAMES = 2
"""Frames after which the next one has to be right."""
SATURATED = Status.INPUT_SATURATED | Status.OUTPUT_SATURATED
WARNINGS = SATURATED | Status.DEPENDENT_OUT_OF_RANGE | Status.IMPLAUSIBLE
"""Bits of the status that tell a receiver to doubt a frame."""
KINDS = ("registers", "written", "kept")
"""Bits of registers, of words in memories that frames write, and of those that stay as they are after a reset."""
SOURCE = Path(__file__).with_name("harness.cpp")

_REGISTER = re.compile(
    r"^(  (?:\(\* no_rw_check \*\) )?reg (?:signed )?(?:\[\d+:\d+\] )?\w+(?: \[\d+:\d+\])?);$", re.M
)  # fmt: skip
"""A register or a memory in generated Verilog."""


@dataclass(frozen=True)
class Upset:
    """A bit of ``name`` was flipped.

    ``seen``: it read back as flipped; ``effect``: state or streams differed a cycle later.  ``told`` and ``silent`` are
    frames, ``span`` is from the first that was not right to the last.
    """

    name: str
    kind: str
    seen: bool
    effect: bool
    told: int
    silent: int
    span: int
    end: str
    healed: bool
    interrupted: bool

    @property
    def outcome(self) -> str:
        """The worst that a receiver gets."""
        return "silent" if self.silent else "told" if self.told else "hung" if self.end == "hung" else "outlived"

    @property
    def recovered(self) -> bool:
        """Whether the frames were right soon again."""
        return self.end == "right" and self.span <= FRAMES


@dataclass(frozen=True)
class Run:
    """All upsets of a core; ``bits`` by kind; ``sound``: every frame of the undisturbed run was right."""

    upsets: list[Upset]
    bits: Counter[str]
    sound: bool


def public(texts: Mapping[str, str]) -> dict[str, str]:
    """Verilog whose registers and memories the harness can write."""
    return {
        name: _REGISTER.sub(r"\1 /* verilator public_flat_rw */;", text) if name.endswith(".v") else text
        for name, text in texts.items()
    }


def parsed(text: str) -> Run:
    """What the harness printed."""
    names, upsets, bits, sound = [], [], Counter[str](), False
    for head, *rest in map(str.split, text.splitlines()):
        if head == "var":
            names.append(rest[0])
        elif head == "bits":
            bits = Counter(dict(zip(KINDS, map(int, rest), strict=True)))
        elif head == "sound":
            sound = rest == ["1"]
        else:
            kind, seen, effect, told, silent, span, end, healed, interrupted = map(int, rest)
            found = bool(seen), bool(effect), told, silent, span, ("right", "wrong", "hung")[end]
            upsets.append(Upset(names[int(head)], KINDS[kind], *found, bool(healed), bool(interrupted)))
    return Run(upsets, bits, sound)


def run(configuration: Configuration, upsets: int, folder: Path, texts: Mapping[str, str] | None = None) -> Run:
    """Flip so many bits; ``texts`` are files to take in place of the core's Verilog.  Raises ``ToolError``."""
    texts = public(configuration.texts) if texts is None else texts
    program = built(configuration, folder, SOURCE, texts, options=["--vpi"])
    of = microarchitecture(configuration.design)
    numbers = SEED, upsets, of.initiation_interval, of.frame_latency, int(WARNINGS)
    return parsed(ran(program, "./core.so", *numbers))


def configurations(quick: bool) -> Iterator[Configuration]:
    """Both estimators, parallel, serial and behind AXI; or a tiny one."""
    parallel: dict[str, Any] = {"adc": Adc(8), "architecture": Architecture(4)}
    serial: dict[str, Any] = {"adc": Adc(8), "architecture": SERIAL}
    sensor, search = SensorArray(2, 2, 4e-3, 2e-3, 3e-3), Search(4)
    yield Configuration("learned", untrained(2, 2, (2, 2), **parallel))
    if not quick:
        yield Configuration("learned, loaded, behind AXI", untrained(2, 3, (3, 3), images="load", **parallel), True)
        yield Configuration("learned, serial, behind AXI", untrained(2, 2, (2, 2), **serial), True, cut_through=True)
        yield Configuration("TFRA", TfraDesign(sensor, "tfra", search=search, **parallel))
        yield Configuration("TFRA, serial", TfraDesign(sensor, "tfra_serial", search=search, **serial))


def share(count: int, total: int) -> dict[str, float]:
    """A count, its share of ``total``, and the share's interval of 95 % by Wilson."""
    return {"count": count, **{name: float(f"{value:.3g}") for name, value in rate(count, total).items()}}


def counted(upsets: list[Upset]) -> dict[str, Any]:
    """Facts of upsets of a kind."""
    total, outcomes = len(upsets), Counter(upset.outcome for upset in upsets)
    lost = [upset for upset in upsets if not upset.recovered]
    again = Counter(upset.span for upset in upsets if upset.end == "right")
    ends = Counter(upset.end for upset in upsets)
    return {
        "upsets": total,
        "seen": sum(upset.seen for upset in upsets),
        "effect": sum(upset.effect for upset in upsets),
        **{outcome: share(outcomes[outcome], total) for outcome in ("outlived", "told", "silent", "hung")},
        "frames_until_right": {str(span): again[span] for span in sorted(again)},
        "stay_wrong": share(ends["wrong"], total),
        "hang": share(ends["hung"], total),
        "hang_with_interrupt": sum(upset.interrupted for upset in upsets if upset.end == "hung"),
        "not_right_after_reset": sum(not upset.healed for upset in upsets),
        f"not_right_after_{FRAMES}_frames": share(len(lost), total),
        "of_blocks": dict(Counter(block_of(upset.name) for upset in lost).most_common(20)),
        "of_names": dict(Counter(upset.name.split(".", 1)[1] for upset in lost).most_common(20)),
    }


def facts(configuration: Configuration, found: Run) -> dict[str, Any]:
    """The record of a configuration."""
    array, of = configuration.array, microarchitecture(configuration.design)
    kinds = {kind: [upset for upset in found.upsets if upset.kind == kind] for kind in KINDS}
    return {
        "name": configuration.name,
        "array": f"{array.sensor.rows}×{array.sensor.columns}",
        "core": core(configuration.design),
        "interval": of.initiation_interval,
        "sound": found.sound,
        "rounds": len(kinds["registers"]) // found.bits["registers"] if found.bits["registers"] else 0,
        "bits": {kind: found.bits[kind] for kind in KINDS},
        **{kind: counted(upsets) for kind, upsets in kinds.items()},
    }


def percent(found: Mapping[str, float]) -> str:
    """A share and its interval, in words."""
    low, middle, high = (100 * found[name] for name in ("rate_low", "rate", "rate_high"))
    return f"{middle:.2f} % ({low:.2f} to {high:.2f})"


def verdict(runs: Mapping[str, Run], records: list[dict[str, Any]], quick: bool) -> Measured:
    """The figure, from the upsets of all configurations by their names, and their records."""
    upsets = [upset for found in runs.values() for upset in found.upsets]
    kinds = {kind: [upset for upset in upsets if upset.kind == kind] for kind in KINDS}
    sampled = kinds["registers"] + kinds["written"]
    lost = [upset for upset in sampled if not upset.recovered]
    silent = {kind: share(sum(one.outcome == "silent" for one in kinds[kind]), len(kinds[kind])) for kind in KINDS}
    if not sampled or not all(kinds.values()):
        return Measured("no bit was flipped", False, {"configurations": records})
    figure = f"{len(upsets):,} upsets, {sum(upset.effect for upset in upsets):,} of them in effect: wrong untold after"
    figure += f" {percent(silent['registers'])} of those of registers, {percent(silent['written'])} of memories that"
    figure += f" frames write, {percent(silent['kept'])} of those that keep coefficients;"
    figure += f" not right after {FRAMES} frames {percent(share(len(lost), len(sampled)))},"
    figure += f" {sum(not upset.healed for upset in lost):,} of {len(lost):,} not after a reset either"
    whole = all(found.sound and all(upset.seen for upset in found.upsets) for found in runs.values())
    effect = all(any(upset.effect for upset in found.upsets) for found in runs.values())
    enough = quick or (len(upsets) >= LEAST and all(record["rounds"] for record in records))
    return Measured(figure, whole and effect and enough and not lost, {"seed": SEED, "configurations": records})


def measure(quick: bool) -> Measured:
    """All configurations, two at a time, or a tiny one with fewer upsets."""

    def one(configuration: Configuration) -> Run:
        upsets = QUICK_UPSETS if quick else UPSETS[configuration.design.architecture.kind]
        with tempfile.TemporaryDirectory() as folder:
            found = run(configuration, upsets, Path(folder))
        progress(f"{configuration.name}: {len(found.upsets):,} upsets")
        return found

    chosen = list(configurations(quick))
    with ThreadPoolExecutor(2) as pool:
        runs = list(pool.map(one, chosen))
    records = [facts(*both) for both in zip(chosen, runs, strict=True)]
    return verdict({one.name: found for one, found in zip(chosen, runs, strict=True)}, records, quick)


LINE = Line(
    7,
    "single bits of registers and memories flipped at random cycles: share of untold wrong frames, frames until right",
    f"1e5 upsets, every flip-flop; right again after {FRAMES} frames",
    "small cores of plain Verilog, none with the cells of a device and no skin; one bit at a time, in the logic's"
    " registers and memories alone, not in the configuration of the FPGA. Told is a frame that is missing or of a wrong"
    " length, a wrong number, fault or interrupt, or a warning of the status. An upset without a wrong word in the next"
    " frames counts as outlived, even if a setting stays changed. Memories that keep coefficients or settings are"
    " wrong until they are written again, and have no part in the target.",
    (*GATEWARE, "bench/exactness/designs.py", "bench/scorecard/words", "bench/scorecard/upsets"),
    measure,
)
