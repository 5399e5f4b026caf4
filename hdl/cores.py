"""The microarchitectures of a core behind one interface: ``design.architecture.kind`` chooses.

Both have the streams ``taxel`` and ``result``; the serial core has ``load``, too, for its coefficients after a reset,
and so has the other one if it is asked for.
"""

from __future__ import annotations

from pathlib import Path

from tfra.hdl.parallel.matvec.images import lane_images
from tfra.hdl.parallel.tfra import timing as parallel_timing
from tfra.hdl.parallel.tfra.core import Core, Probe
from tfra.hdl.parallel.tfra.core import probes as parallel_probes
from tfra.hdl.primitives import cell_models, models
from tfra.hdl.serial import timing as serial_timing
from tfra.hdl.serial.core import SerialCore
from tfra.hdl.serial.program.frame import program
from tfra.hdl.serial.program.memory import store_image
from tfra.hdl.serial.sizes import sizes
from tfra.hdl.serial.store import cells
from tfra.model.design import Design
from tfra.model.fixed.numbers import Ints


def is_serial(design: Design) -> bool:
    """True if ``design`` is of the serial kind."""
    return design.architecture.kind == "serial"


def make_core(design: Design) -> Core | SerialCore:
    """The core of ``design``; raises ``ValueError`` as :func:`check_size`."""
    return SerialCore(design) if is_serial(design) else Core(design)


def check_size(design: Design) -> None:
    """Raise ``ValueError`` for a design that the serial core's memories can't hold."""
    if is_serial(design):
        program(design)
        store_image(design)


def timing(design: Design) -> parallel_timing.Timing | serial_timing.Timing:
    """Latency, frame latency, initiation interval and multiplications of the core."""
    return serial_timing.Timing(design) if is_serial(design) else parallel_timing.Timing(design)


def regular(design: Design) -> tuple[slice, int]:
    """Which of the times between frames the initiation interval is the mean of, and the frames that show it."""
    if is_serial(design):
        return slice(None), 2
    return slice(parallel_timing.SETTLED, 2 * parallel_timing.SETTLED), parallel_timing.ENOUGH


def lanes(design: Design) -> int:
    """Multiply-accumulate lanes."""
    return sizes(design).lanes if is_serial(design) else design.architecture.mac_lanes


def probes(design: Design) -> tuple[Probe, ...]:
    """Streams between blocks that a simulation may watch: the serial core has none."""
    return () if is_serial(design) else parallel_probes(design)


def core_models(design: Design) -> tuple[Path, ...]:
    """Verilog files with models of the cells that the core has instances of."""
    return models(cells(design.target)) if is_serial(design) else cell_models(design.target)


def loaded(design: Design) -> Ints | None:
    """Coefficients in the order in which the core wants them after a reset, one a transfer; None if it has them."""
    if is_serial(design):
        return store_image(design).ravel()
    return lane_images(design).ravel() if design.images == "load" else None
