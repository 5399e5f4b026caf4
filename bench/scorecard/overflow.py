"""Line 4: words that can't overflow, or that are limited and told by a flag."""

from collections import Counter
from typing import Any

import numpy as np

from bench.parts.axi_cost import PRESETS
from bench.publish import ROOT
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from tfra.codegen.config.read import load
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.design import Design
from tfra.model.tfra import Status
from tfra.study.signals.instruments import instrument
from tfra.study.signals.measures import Word

FRAMES = 1000
"""Contacts, and as many frames of noise, in which words are looked at that are shifted to fill their format."""


def reason(word: Word, used: dict[str, Any]) -> str:
    """Why a word can't overflow untold, or "" where it could.

    ``used`` is what was observed of it in frames without OUTPUT_SATURATED, where none may be cut.
    """
    if word.proven:
        return "by its bound" if word.bound <= 2 ** (word.bits - word.signed) else ""
    if used["saturated"]:
        return ""
    return "limited with a flag" if word.name == "result" else "shifted to fit"


def judged(design: Design) -> dict[str, str]:
    """The reason for every signal of ``design``."""
    codes = np.concatenate([contact_codes(design, FRAMES, 1), directed_codes(design), wild_codes(design, FRAMES, 1)])
    inside = instrument(design)
    told = design.model(codes).words[:, -1] & Status.OUTPUT_SATURATED != 0
    ranges = inside.measure(codes[~told])["ranges"]
    return {name: reason(word, ranges[name]) for name, word in inside.catalogue.items()}


def measure(quick: bool) -> Measured:
    """All signals of the presets, or of two of them."""
    found = {}
    for name in ("small", "learned_small") if quick else PRESETS:
        progress(name)
        found[name] = judged(load(ROOT / "examples" / f"{name}.toml").design)
    counts = Counter(why for reasons in found.values() for why in reasons.values())
    unproven = {name: [signal for signal, why in reasons.items() if not why] for name, reasons in found.items()}
    total = sum(counts.values())
    good = total - counts[""]
    told = ", ".join(f"{count} {why or 'otherwise'}" for why, count in sorted(counts.items()))
    return Measured(f"{good} of {total} signals: {told}", good == total, {"otherwise": unproven})


LINE = Line(
    4,
    "signals that can't overflow by proof, or saturate with a flag",
    "100 %",
    "operands, sums and words of the dividers are shifted by the largest of their frame; that no word is cut in a frame"
    f" without the flag is observed in {2 * FRAMES:,} frames and the directed ones, not proven.",
    (*GATEWARE, "study/signals", "bench/scorecard/overflow.py"),
    measure,
)
