"""Whole cores in Amaranth's simulator: any small design, with the result words of frames and their cycles."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np

from tfra.hdl.parallel.tfra.core import TfraCore
from tfra.model.choices import SCALARS, Adc, Architecture, Formats, Search
from tfra.model.fixed.tfra.design import SIGNALS, TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray
from tfra.sim.harness import run


def stream(design, codes, **stalls):
    """Result words ``(n, words)``, last marks, and the cycles of last taxels and of result words."""
    want = FixedTfra(design)(codes).words
    seen = run(TfraCore(design), {"taxel": codes.ravel().tolist()}, {"result": want.size}, **stalls)
    words = np.array([word["data"] for word in seen.values["result"]]).reshape(want.shape)
    last = np.array([word["last"] for word in seen.values["result"]]).reshape(want.shape)
    taken = np.array(seen.cycles["taxel"]).reshape(len(codes), -1)[:, -1]
    return words, want, last, taken, np.array(seen.cycles["result"]).reshape(want.shape)


def random_design(seed):
    """Any small array with any number of lanes, any number of words a cycle, and any contact threshold."""
    rng = random.Random(seed)
    rows, columns, steps = rng.randrange(2, 8), rng.randrange(2, 8), rng.choice([4, 12, 33])
    most = 4 * ((rows + 1) // 2) * ((columns + 1) // 2)
    lanes = rng.choice(range(4, most + 1, 4))
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    architecture = Architecture(lanes, rng.choice([1, 2, 4]))
    adc = Adc(contact_threshold=rng.choice([None, 0, rng.randrange(2000)]))
    return TfraDesign(sensor, adc=adc, search=Search(steps), architecture=architecture)


def mixed_design(seed):
    """A random design whose signals have word lengths of their own: the first draw that fits together."""
    design, rng = random_design(seed), random.Random(seed)
    while True:
        own = tuple((name, rng.randrange(10 if name in SCALARS else 6, 28)) for name in SIGNALS if rng.random() < 0.6)
        lengths = rng.randrange(6, 28), rng.randrange(design.adc.bits, 28), rng.randrange(17), rng.randrange(17)
        try:
            mixed = replace(design, formats=Formats("mixed", *lengths, own))
            _ = mixed.widths
        except ValueError:
            continue
        return mixed
