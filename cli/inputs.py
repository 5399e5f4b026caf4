"""How a recording is read: CONFIG's [input], and the options of a command that override it."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tfra.recordings.input import FILES, Coding, Input, Order, Sign, Unit, overridden
from tfra.runtime.errors import InputError, quoted

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.recordings.frames import Recording

Given = Mapping[str, Any]
"""The options given by the user: fields of ``Input`` by name."""


def _option(kind: Any, help: str, *names: str, **more: Any) -> Any:
    panel = "How FRAMES are read; these options override CONFIG's section input"
    return Annotated[kind | None, typer.Option(*names, help=help, rich_help_panel=panel, **more)]


OPTIONS: dict[str, Any] = {
    "unit": _option(Unit, "Unit of the numbers; codes are those of CONFIG's converter. Default: Pa."),
    "compression": _option(Sign, "Sign of compression. Default: negative."),
    "coding": _option(
        Coding, "Two's complement; offset binary (half of the range at rest); or codes of one sign. Default: signed."
    ),
    "pa_per_code": _option(float, "Stress of one code. Default: that of CONFIG's converter.", metavar="PA", min=1e-12),
    "rest_code": _option(float, "Code of every taxel at rest. Default: 0, of offset binary half of the range."),
    "tare_frames": _option(
        int, "The first N frames show the array at rest; their mean is subtracted.", metavar="N", min=0, max=1_000_000
    ),
    "tare": _option(Path, "All frames of this file show the array at rest; their mean is subtracted.", metavar="FILE"),
    "drift_frames": _option(
        int, "Between contacts the offset follows with this time constant in frames.", metavar="N", min=0
    ),
    "average": _option(
        int, "The mean of N frames is one, as in the core: 1, 2, 4, ... 64. Default: 1.", metavar="N", min=1, max=64
    ),
    "dead": _option(
        list[str], "A taxel that is computed from its neighbours, from 0; may be repeated.", metavar="ROW,COLUMN"
    ),
    "calibration": _option(
        Path, "A file with the gains, numbers at rest and dead ones of the taxels.", metavar="CAL.toml"
    ),
    "order": _option(Order, "Order of a frame's numbers: along rows or along columns. Default: rows."),
    "flip_x": _option(bool, "Mirror the array along x.", "--flip-x/--no-flip-x"),
    "flip_y": _option(bool, "Mirror the array along y.", "--flip-y/--no-flip-y"),
    "skip_columns": _option(
        int, "The first N columns are no taxels; the first of them is the time.", metavar="N", min=0, max=1000
    ),
    "columns": _option(
        str,
        "Columns of text that are taxels, from 1, or their names in the header, as T_{row}_{column}.",
        metavar="FIRST-LAST|NAMES",
    ),
    "strict": _option(bool, "Refuse text with a line that is no frame; else a hundredth of them may be.", "--strict"),
    "topic": _option(str, "Topic of the frames in a log. Default: the only one that fits.", metavar="NAME"),
}


def reads_recording(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options above to ``command``; its parameter ``given`` receives those that are set."""
    own = inspect.signature(command, eval_str=True)
    kept = [parameter for parameter in own.parameters.values() if parameter.name != "given"]
    ours = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind)
        for name, kind in OPTIONS.items()
    ]

    @wraps(command)
    def reading(**arguments: Any) -> None:
        options = {name: arguments.pop(name) for name in OPTIONS}
        command(**arguments, given={name: value for name, value in options.items() if value not in (None, [])})

    plain = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in kept]
    reading.__dict__["__signature__"] = inspect.Signature([*plain, *ours])
    reading.__annotations__ = {parameter.name: parameter.annotation for parameter in (*plain, *ours)}
    return reading


def for_recording(project: Project, path: Path, given: Given, command: str) -> Project:
    """Return ``project`` with the ``input`` for the recording at ``path``.

    Raises ``InputError`` for options that contradict each other.
    """
    from tfra.recordings.frames import read_as

    return _read_by(project, lambda: read_as(path, project.input, _parsed(given)), command)


def for_stream(project: Project, given: Given, command: str) -> Project:
    """Return ``project`` with the ``input`` for a stream of lines; raises as ``for_recording``."""
    return _read_by(project, lambda: overridden(project.input, _parsed(given)), command)


def _read_by(project: Project, choose: Callable[[], Input], command: str) -> Project:
    try:
        return replace(project, input=choose())
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        raise InputError(f"tfra {command}", f"--{key.replace('_', '-')}", reason) from None


def _parsed(given: Given) -> Given:
    """``given`` with places of taxels as numbers; raises ``ValueError`` for one that is none."""
    if "dead" not in given:
        return given
    places = [re.fullmatch(r"(\d{1,4}),(\d{1,4})", text) for text in given["dead"]]
    if None in places:
        raise ValueError(f"dead: ROW,COLUMN from 0 is needed, got {quoted(given['dead'][places.index(None)])}")
    return {**given, "dead": [tuple(map(int, place.groups())) for place in places if place]}


def files_of(given: Input) -> list[Path]:
    """The files that ``given`` names."""
    return [file for name in FILES if (file := getattr(given, name))]


def frames_at(path: Path, project: Project) -> Recording:
    """Return the recording at ``path``, read as ``project.input`` says; raises ``InputError``."""
    from tfra.recordings.frames import read_recording

    return read_recording(path, project.array.sensor, project.array.adc, project.input)
