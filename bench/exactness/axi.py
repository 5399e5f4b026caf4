"""Cores behind AXI, in Verilog, against the model: malformed frames among good ones, with pauses on both streams.

``python -m bench.exactness.axi [--scale S]`` sends the frames of every case through Icarus and through Verilator,
driven by cocotbext-axi.  Every good frame has to be answered once, in order and bit for bit, and every other one to be
counted.  Writes ``bench/results/axi.json`` and the table in docs/ip.md, and exits with 1 for any difference.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from bench.exactness.designs import core, untrained
from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.wrapper import module_name, wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.choices import SERIAL, Adc, Architecture, Bus
from tfra.model.converter import saturated
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.design import Design
from tfra.sim.tools import choose, environment

RUN, FORCES, CHECK_SEQUENCE, CUT_THROUGH = 1 << 0, 1 << 3, 1 << 6, 1 << 9
"""Bits of CONTROL."""

SATURATION, SEQUENCE_GAP, OUT_OF_RANGE = 1 << 2, 1 << 5, 1 << 8
"""Faults in the second word of an output frame."""
FORMAT = 1 << 24

Frame = tuple[int, list[int]]
"""Number of a frame, and its beats."""


@dataclass(frozen=True)
class Traffic:
    """``sent`` are all frames, ``answers`` those that have to come back, word by word; ``counters`` by register."""

    sent: list[Frame]
    answers: list[list[int]]
    counters: dict[str, int]


def traffic(design: Design, count: int, seed: int, malformed: float = 0.3) -> Traffic:
    """``count`` random frames, contacts, noise and directed ones; a share of them is ``malformed``.

    Those are too short, too long or a single beat.  Numbers have gaps, and words bits beyond those of the converter.
    """
    rng = np.random.default_rng(seed)
    codes = _codes(design, count, rng)
    bad, wide, gap = (rng.random(count) < share for share in (malformed, 0.05 * (design.adc.bits < 16), 0.05))
    users = np.cumsum(1 + gap * rng.integers(1, 1 << 16, count)) & 0xFFFF
    words = _words(design, codes, wide.astype(np.int64), rng)
    beats = [_beats(each, design.bus.taxels_per_beat, rng) for each in words]
    whole = len(beats[0])
    lengths = np.where(bad, [_length(whole, rng) for _ in beats], whole)
    sent = [(int(user), _resized(each, length, rng)) for user, each, length in zip(users, beats, lengths, strict=True)]
    good = lengths == whole
    jumps = np.flatnonzero(np.diff(users) & 0xFFFF != 1) + 1
    faults = SATURATION * saturated(design, codes) + OUT_OF_RANGE * wide
    faults[jumps] += SEQUENCE_GAP
    head = np.stack([np.arange(count) & 0xFFFF | users << 16, faults | FORMAT], axis=1)[good]
    results = design.model(codes[good]).words & 0xFFFFFFFF
    status = results[:, -1] & (32 | 64)
    counters = {
        "FRAMES_IN": int(good.sum()),
        "FRAMES_OUT": int(good.sum()),
        "FRAMES_DROPPED": int((~good).sum()),
        "FRAMES_SATURATED": int(((faults[good] & SATURATION != 0) | (status != 0)).sum()),
    }
    return Traffic(sent, np.concatenate([head, results], axis=1).tolist(), counters)


def _codes(design: Design, count: int, rng: np.random.Generator) -> Ints:
    seed = int(rng.integers(1 << 31))
    contacts = contact_codes(design, min(count, 60), seed)
    frames = np.concatenate([contacts, directed_codes(design), wild_codes(design, count, seed)])
    return frames[rng.permutation(len(frames))[:count]]


def _words(design: Design, codes: Ints, wide: Ints, rng: np.random.Generator) -> Ints:
    """Slots of 16 bits; a taxel of each ``wide`` frame has a wrong bit beyond those of the converter."""
    words = codes.reshape(len(codes), -1) & 0xFFFF
    where = rng.integers(words.shape[1], size=len(words))
    words[np.arange(len(words)), where] ^= wide << rng.integers(min(design.adc.bits, 15), 16, len(words))
    return words


def _beats(words: Ints, taxels: int, rng: np.random.Generator) -> list[int]:
    """Beats of that many taxels; the last one is filled up with anything."""
    filled = np.concatenate([words, rng.integers(1 << 16, size=-len(words) % taxels)]).reshape(-1, taxels)
    return [sum(int(word) << (16 * place) for place, word in enumerate(beat)) for beat in filled]


def _length(whole: int, rng: np.random.Generator) -> int:
    """Beats of a malformed frame."""
    choices = [1, whole - 1, int(rng.integers(1, whole)), whole + 1, int(rng.integers(whole + 1, 2 * whole + 2))]
    return int(rng.choice([length for length in choices if length > 0]))


def _resized(beats: list[int], length: int, rng: np.random.Generator) -> list[int]:
    more = rng.integers(1 << 16, size=max(0, length - len(beats)))
    return beats[:length] + [int(word) for word in more]


def cases() -> tuple[tuple[Design, dict[str, int]], ...]:
    """Designs, and the frames for each in both simulators."""
    fast = load(ROOT / "examples" / "fast.toml").design
    return (
        (untrained(4, 4, (6, 4), architecture=Architecture(16)), {"icarus": 3000, "verilator": 10_000}),
        (
            untrained(3, 5, (5, 7), architecture=SERIAL, adc=Adc(12), bus=Bus(2)),
            {"icarus": 200, "verilator": 1000},
        ),
        (
            untrained(3, 5, (5, 7), architecture=Architecture(12, 2), images="load", bus=Bus(4)),
            {"icarus": 500, "verilator": 2000},
        ),
        (replace(fast, target="portable"), {"icarus": 100, "verilator": 400}),
    )


def verilog(design: Design) -> dict[str, str]:
    """Texts of the core and of its wrapper, by file name."""
    return {f"{design.name}.v": to_verilog(design), f"{module_name(design)}.v": wrapper_verilog(design)}


def run(
    design: Design,
    frames: Traffic,
    simulator: str,
    texts: dict[str, str],
    seed: int = 0,
    *,
    pauses: bool = True,
    cut_through: bool = False,
) -> dict[str, Any]:
    """Simulate; the frames that came back, and the registers.  Raises ``RuntimeError`` for a simulation that fails."""
    built = microarchitecture(design)
    loaded = built.loaded
    job = {
        "frames": frames.sent,
        "expected": len(frames.answers),
        "coefficients": [] if loaded is None else loaded.tolist(),
        "control": RUN | FORCES | CHECK_SEQUENCE | CUT_THROUGH * cut_through,
        "silence": 20_000 + 20 * built.frame_latency,
        "pauses": pauses,
        "seed": seed,
    }
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for name, text in texts.items():
            (place / name).write_text(text)
        (place / "job.json").write_text(json.dumps(job))
        variables = {**environment(choose(simulator), place), "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-m", "bench.exactness.axi_play", simulator, module_name(design), folder]
        done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, check=False)
        if not (place / "outcome.json").exists():
            raise RuntimeError((done.stdout + done.stderr)[-4000:])
        outcome: dict[str, Any] = json.loads((place / "outcome.json").read_text())
    return outcome


def differences(frames: Traffic, outcome: dict[str, Any]) -> list[str]:
    """What came back otherwise than it has to, one line each."""
    back, found = outcome["back"], []
    if len(back) != len(frames.answers):
        found.append(f"{len(back)} frames came back, {len(frames.answers)} are expected")
    for number, ((cut, words, _), expected) in enumerate(zip(back, frames.answers, strict=False)):
        if cut or words != expected:
            places = [place for place, pair in enumerate(zip(words, expected, strict=False)) if pair[0] != pair[1]]
            found.append(f"frame {number}: {len(words)} words, differing at {places[:5]}, tuser {cut}")
    states = outcome["states"]
    found += [f"{name} is {states[name]}, not {n}" for name, n in frames.counters.items() if states[name] != n]
    return found


def measure(design: Design, counts: dict[str, int], seed: int) -> list[dict[str, Any]]:
    """One record for each simulator, in both modes."""
    texts, records = verilog(design), []
    for (simulator, count), cut_through in product(counts.items(), (False, True)):
        frames, start = traffic(design, count, seed), time.perf_counter()
        found = differences(frames, run(design, frames, simulator, texts, seed, cut_through=cut_through))
        records.append(
            {
                "array": f"{design.sensor.rows}×{design.sensor.columns}",
                "core": core(design) + (", loaded" if microarchitecture(design).loaded is not None else ""),
                "taxels_per_beat": design.bus.taxels_per_beat,
                "simulator": simulator,
                "cut_through": cut_through,
                "frames": count,
                "malformed": frames.counters["FRAMES_DROPPED"],
                "words": sum(len(answer) for answer in frames.answers),
                "differences": found[:20],
                "seconds": round(time.perf_counter() - start, 1),
            }
        )
        print(records[-1], flush=True)
    return records


def table(records: list[dict[str, Any]]) -> str:
    """Markdown: a row for each design and mode, whose simulators stand side by side."""
    lines = [
        "| array | core | taxels a beat | mode | frames in icarus / verilator | malformed | words | differences |",
        "|---|---|---:|---|---:|---:|---:|---:|",
    ]
    designs: dict[tuple[str, str, int, bool], list[dict[str, Any]]] = {}
    for record in records:
        key = record["array"], record["core"], record["taxels_per_beat"], record["cut_through"]
        designs.setdefault(key, []).append(record)
    for (array, core_name, taxels, cut_through), runs in designs.items():
        mode = "cut-through" if cut_through else "store and forward"
        frames = " / ".join(f"{run['frames']:,}" for run in runs)
        malformed = sum(run["malformed"] for run in runs)
        words = sum(run["words"] for run in runs)
        found = sum(len(run["differences"]) for run in runs)
        lines.append(f"| {array} | {core_name} | {taxels} | {mode} | {frames} | {malformed:,} | {words:,} | {found} |")
    return "\n".join(lines)


def main() -> int:
    """Run, print, publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scale", type=float, default=1.0, help="share of the frames, for a shorter run")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    records = []
    for design, counts in cases():
        fewer = {simulator: max(1, int(count * options.scale)) for simulator, count in counts.items()}
        records += measure(design, fewer, options.seed)
    publish("axi", {"seed": options.seed, "records": records}, table(records), "docs/ip.md")
    return int(any(r["differences"] for r in records))


if __name__ == "__main__":
    sys.exit(main())
