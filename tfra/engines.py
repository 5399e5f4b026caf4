"""The engines that estimate forces: each turns frames of stress into results.

Heavy modules are imported when an engine runs, so that ``import tfra`` and ``tfra --help`` stay fast.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfra.codegen.config.core import check_core
from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.model.arrays import Floats, Ints
    from tfra.model.fixed.design import Design
    from tfra.model.tfra import Result

CHUNK = 512  # frames between two steps of the progress bar

Advance = Callable[[int], None]
"""Called with the number of frames just finished."""


class Engine(StrEnum):
    """The engines by name."""

    FLOAT = "float"
    FIXED = "fixed"
    C = "c"
    RTL = "rtl"
    TWO_VARIABLE = "two-variable"


DOUBLE = (Engine.FLOAT, Engine.TWO_VARIABLE)
"""Engines that can use exact stress; the others use the converter's codes."""


def silent(done: int) -> None:
    """Report nothing."""


def run(
    engine: Engine,
    project: Project,
    frames: Floats,
    source: str | Path,
    advance: Advance = silent,
    converted: bool = False,
) -> Result:
    """Return the result of ``frames (n, rows, columns)`` in Pa.

    ``converted`` gives the engines of ``DOUBLE`` the converter's codes, in Pa, instead of exact stress.  Raises
    ``InputError`` naming ``source`` for frames over full scale, or CONFIG where an engine needs a core and there can be
    none, and ``SimulationError`` or ``ProtocolError`` of ``tfra.sim.run`` for a failed simulation.
    """
    import numpy as np

    from tfra.model.fixed.words import decode

    model = estimator(engine, project)
    if engine in DOUBLE:
        if converted:
            frames = np.multiply(codes(project, frames, source), project.design.adc.lsb, dtype=np.float64)
        return _in_chunks(model, frames, advance)
    measured = codes(project, frames, source)
    if engine is Engine.RTL:  # one simulation, which tells how far it is
        from tfra.sim.run import simulate

        return decode(project.design, simulate(project.design, measured, progress=advance).words)
    return _in_chunks(model, measured, advance)


def estimator(engine: Engine, project: Project) -> Callable[[Any], Result]:
    """Return an engine for many calls: a function of frames ``(n, rows, columns)`` in Pa, or of the converter's codes.

    Engines of ``DOUBLE`` take Pa.  Raises ``InputError`` as :func:`run`; what it returns raises as ``simulate``.
    """
    design = project.design
    if engine in DOUBLE:
        from tfra.model.two_variable import TwoVariable

        return TwoVariable.of(design) if engine is Engine.TWO_VARIABLE else design.float_model
    from tfra.model.fixed.words import decode

    check_core(project)
    words = _words(engine, design)
    return lambda given: decode(design, words(given))


def _words(engine: Engine, design: Design) -> Callable[[Ints], Ints]:
    """Result words of codes, by an engine that gives the core's."""
    if engine is Engine.RTL:
        from tfra.sim.run import simulate

        return lambda given: simulate(design, given).words
    if engine is Engine.C:
        from tfra.sim.compiled import Compiled

        return Compiled(design).words
    fixed = design.model
    return lambda given: fixed(given).words


def codes(project: Project, frames: Floats, source: str | Path) -> Ints:
    """Return the converter codes of ``frames`` in Pa; raises ``InputError`` naming ``source`` beyond full scale."""
    from tfra.model.converter import quantise
    from tfra.recordings.diagnosis import over_full_scale

    try:
        return quantise(project.design, frames)
    except ValueError as error:  # over full scale
        raise InputError(source, "", f"{error}{over_full_scale(project.design, frames, project.input)}") from None


def _in_chunks(run: Callable[[Any], Result], data: Any, advance: Advance) -> Result:
    """Run ``data`` in chunks and join their results."""
    import numpy as np

    from tfra.recordings.results import KEYS, OPTIONAL

    results = []
    for start in range(0, len(data), CHUNK):
        results.append(run(data[start : start + CHUNK]))
        advance(len(results[-1].mu))
    keys = (*KEYS, *(key for key in OPTIONAL if getattr(results[0], key) is not None))
    parts: dict[str, Any] = {key: np.concatenate([getattr(result, key) for result in results]) for key in keys}
    return replace(results[0], **parts)
