"""For the tests of parallel blocks: designs of TFRA and random ones, words, blocks joined to one, a test bench."""

import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

import numpy as np
from amaranth import Elaboratable, Module
from amaranth.lib import wiring
from amaranth.sim import Simulator

from tfra.hdl.lib.streams import broadcast
from tfra.model.arrays import Ints
from tfra.model.choices import FORMATS, SCALARS, Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import SIGNALS, TfraDesign
from tfra.model.sensor import SensorArray
from tfra.sim.harness import port

D = TypeVar("D", bound=Design)


def make(
    rows: int,
    columns: int,
    formats: str | Formats = "standard",
    *,
    bits: int = 14,
    threshold: int | None = None,
    steps: int = 100,
    tolerance: float = 0.0,
    lanes: int = 4,
    words: int = 4,
    pitches: tuple[float, float] = (4.0, 2.0),
    thickness: float = 3.0,
) -> TfraDesign:
    """A design with these formats, or those of this name; pitches and thickness in mm."""
    return TfraDesign(
        SensorArray(rows, columns, pitches[0] * 1e-3, pitches[1] * 1e-3, thickness * 1e-3),
        adc=Adc(bits, contact_threshold=threshold),
        search=Search(steps, tolerance),
        formats=FORMATS[formats] if isinstance(formats, str) else formats,
        architecture=Architecture(lanes, words),
    )


def label(design: Design) -> str:
    """Size, lanes, words a cycle and formats of a design, for the name of a test."""
    sensor, architecture = design.sensor, design.architecture
    formats = design.formats.name.replace(" ", "-")
    return f"{sensor.rows}x{sensor.columns}-{architecture.mac_lanes}-{architecture.vector_words}-{formats}"


VECTORS = [
    make(4, 4),
    make(3, 5, "wide"),
    make(2, 2),
    make(4, 6, Formats("long vectors", 12, 10, 16, 4), bits=10),
    make(3, 2, Formats("short vectors", 12, 27, 0, 0), bits=6),
    make(3, 4, words=2),
    make(2, 2, words=1),
    make(5, 4, words=1),
]
"""Small designs of every kind: words a cycle, and vectors longer and shorter than multiplier operands."""


def mixed(design: D, seed: int, signals: Sequence[str], own: float) -> D:
    """``design`` with words of their own length for a part ``own`` of the ``signals``: the first draw that fits."""
    rng = random.Random(seed)
    while True:
        chosen = ((name, 10 if name in SCALARS else 6) for name in signals if rng.random() < own)
        lengths = tuple((name, rng.randrange(least, 28)) for name, least in chosen)
        common = rng.randrange(6, 28), rng.randrange(design.adc.bits, 28), rng.randrange(17), rng.randrange(17)
        try:
            drawn = replace(design, formats=Formats("mixed", *common, lengths))
            _ = drawn.widths
        except ValueError:
            continue
        return drawn


def random_design(seed: int) -> TfraDesign:
    """Any small array with any number of lanes, any number of words a cycle, and any contact threshold."""
    rng = random.Random(seed)
    rows, columns, steps = rng.randrange(2, 8), rng.randrange(2, 8), rng.choice([4, 12, 33])
    lanes = rng.choice(range(4, 4 * ((rows + 1) // 2) * ((columns + 1) // 2) + 1, 4))
    words = rng.choice([1, 2, 4])
    threshold = rng.choice([None, 0, rng.randrange(2000)])
    return make(rows, columns, steps=steps, lanes=lanes, words=words, threshold=threshold)


def mixed_design(seed: int) -> TfraDesign:
    """A random design whose signals have word lengths of their own."""
    return mixed(random_design(seed), seed, SIGNALS, 0.6)


def random_words(rng: np.random.Generator, bits: int, shape: tuple[int, ...]) -> Ints:
    """Signed words of ``bits`` and less: every length is as likely, ends of the range among them."""
    top = np.int64(1) << rng.integers(0, bits, shape)
    values = np.where(rng.random(shape) < 0.2, rng.choice([-1, 1], shape) * top, rng.integers(-top, top))
    return np.clip(values, -(1 << (bits - 1)), (1 << (bits - 1)) - 1)


def simulate(dut: Any, bench: Callable[[Any], Any]) -> None:
    """Run ``bench`` beside ``dut`` to its end."""
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()


class Joined(Elaboratable):
    """Blocks as one: attributes of their names, so that "block.port" is a port.

    Arguments:
        wires: pairs of such ports: a stream, and its sink; one without backpressure has any number of sinks.
    """

    def __init__(self, wires: Iterable[tuple[str, str]], **blocks: Any) -> None:
        self._wires, self._blocks = wires, blocks
        vars(self).update(blocks)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in self._blocks.items():
            m.submodules[name] = block
        for source, sink in (map(partial(port, self), pair) for pair in self._wires):
            connect = broadcast if source.signature.always_ready else wiring.connect
            connect(m, source, sink)
        return m
