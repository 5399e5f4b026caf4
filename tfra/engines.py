"""The engines that estimate forces: each turns frames of stress into results.

Heavy modules are imported when an engine runs, so that ``import tfra`` and ``tfra --help`` stay fast.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from tfra.codegen.config.core import check_core
from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.model.arrays import Floats, Ints
    from tfra.model.fixed.design import Design
    from tfra.model.skin.result import SkinResult
    from tfra.model.skin.skin import Skin
    from tfra.model.tfra import Result

Kind = TypeVar("Kind")

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
    from tfra.model.fixed.words import decode
    from tfra.model.tfra import joined

    model = estimator(engine, project)
    given = taken(engine, project, frames, source, converted)
    if engine is Engine.RTL:  # one simulation, which tells how far it is
        from tfra.sim.run import simulate

        return decode(project.design, simulate(project.design, given, progress=advance).words)
    return joined(list(_in_chunks(model, given, advance)))


def run_skin(
    engine: Engine,
    project: Project,
    skin: Skin,
    frames: Floats,
    source: str | Path,
    advance: Advance = silent,
    converted: bool = False,
) -> SkinResult:
    """The same for the ``skin`` of ``project``: its contacts, and the forces of each."""
    from tfra.model.skin.records import decode_records
    from tfra.model.skin.result import joined

    given = taken(engine, project, frames, source, converted)
    if engine is Engine.RTL:
        from tfra.sim.run import simulate

        check_core(project)
        return decode_records(skin, simulate(skin, given, progress=advance).words)
    return joined(list(_in_chunks(skin_estimator(engine, project, skin), given, advance)))


def skin_estimator(engine: Engine, project: Project, skin: Skin) -> Callable[[Any], SkinResult]:
    """The same as :func:`estimator` for the ``skin`` of ``project``."""
    if engine in DOUBLE:
        from tfra.model.skin.result import estimate

        windows = estimator(engine, project)
        return lambda stress: estimate(skin, stress, windows)
    from tfra.model.skin.records import decode_records

    check_core(project)
    words = _records(engine, skin)
    return lambda given: decode_records(skin, words(given))


def taken(engine: Engine, project: Project, frames: Floats, source: str | Path, converted: bool = False) -> Any:
    """``frames`` in Pa as the engine takes them: codes, stress in Pa, or that of the codes; raises as :func:`run`."""
    if engine in DOUBLE and not converted:
        return frames
    measured = codes(project, frames, source)
    return measured * project.array.adc.lsb if engine in DOUBLE else measured


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


def _records(engine: Engine, skin: Skin) -> Callable[[Ints], Ints]:
    """Records of codes of a skin."""
    if engine is Engine.C:
        from tfra.sim.compiled_skin import CompiledSkin

        return CompiledSkin(skin).words
    if engine is Engine.RTL:
        from tfra.sim.run import simulate

        return lambda given: simulate(skin, given).words
    from tfra.model.skin.records import records

    windows = _words(engine, skin.window)
    return lambda given: records(skin, given, windows)


def codes(project: Project, frames: Floats, source: str | Path) -> Ints:
    """Return the converter codes of ``frames`` in Pa; raises ``InputError`` naming ``source`` beyond full scale."""
    from tfra.model.converter import quantise
    from tfra.recordings.diagnosis import over_full_scale

    try:
        return quantise(project.array, frames)
    except ValueError as error:  # over full scale
        raise InputError(source, "", f"{error}{over_full_scale(project.array, frames, project.input)}") from None


def _in_chunks(run: Callable[[Any], Kind], data: Any, advance: Advance) -> Iterator[Kind]:
    """The result of each chunk of ``data``."""
    for start in range(0, len(data), CHUNK):
        part = data[start : start + CHUNK]
        yield run(part)
        advance(len(part))
