"""``tfra live``: forces of arriving frames, in a browser."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from tfra.cli.common import Config, progress
from tfra.cli.inputs import Given, files_of, for_recording, for_stream, frames_at, reads_recording
from tfra.cli.messages import print_error
from tfra.cli.reports import ArrayReport, SkinReport
from tfra.codegen.config.core import check_core
from tfra.engines import DOUBLE, Engine, codes, estimator, skin_estimator, taken
from tfra.runtime.errors import InputError, require

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.model.arrays import Bools, Floats
    from tfra.model.skin.result import SkinResult
    from tfra.model.tfra import Result
    from tfra.recordings.intake import Intake
    from tfra.recordings.record import Record
    from tfra.view.feed import Feed

Source = Annotated[
    str,
    typer.Argument(
        metavar="SOURCE",
        help="A recording to replay, - for standard input, tcp://HOST:PORT or serial:/dev/NAME?baud=115200.",
    ),
]
LiveEngine = Annotated[Engine, typer.Option(help="Engine, as in tfra estimate.")]
Rate = Annotated[
    float | None, typer.Option(metavar="F", help="Frames a second of a replay. Default: by its times, else 100.")
]
Port = Annotated[int, typer.Option(metavar="N", min=0, max=65535, help="Of the page, on 127.0.0.1; 0: any free port.")]
Out = Annotated[
    Path | None, typer.Option(metavar="RESULT.npz", help="Also write what was estimated, at the end, as tfra estimate.")
]
Stay = Annotated[bool, typer.Option("--stay", help="Serve the page after the source has ended, until Ctrl-C.")]


class _Shown(NamedTuple):
    """The feed of a page, the page, the engine as a function of stress, and what is said of its results."""

    feed: Feed
    page: str
    record: Record[Any]
    report: Callable[[Floats, Any], ArrayReport | SkinReport]


class _Source(NamedTuple):
    """The project with a source's ``input``, its name, its frames in Pa, or faults of its lines, and dead taxels."""

    project: Project
    name: str
    frames: Iterator[Floats | str]
    dead: Bools | None
    tare: Intake | None = None


@reads_recording
def live(
    config: Config,
    source: Source,
    engine: LiveEngine = Engine.FLOAT,
    rate: Rate = None,
    out: Out = None,
    port: Port = 8347,
    stay: Stay = False,
    given: Given | None = None,
) -> None:
    """Show forces in a browser as frames arrive, from a stream of text, one frame a line, or from a recording.

    Frames that the engine or the browser has no time for are dropped.

    It ends with its source, once a page has all frames, or with --out without a page, or by Ctrl-C.
    """
    require("tfra live", "view", "plotly")
    import numpy as np

    from tfra.codegen.config.read import load
    from tfra.recordings.results import check_result
    from tfra.runtime.processes import Stopped
    from tfra.view.server import serving

    if rate is not None and not 0 < rate <= 1e6:
        raise InputError("tfra live", "--rate", f"more than 0 frames a second are needed, up to 1e6, got {rate:g}")
    project = load(config)
    if engine not in DOUBLE:
        check_core(project)  # before a stream is opened
    project, name, frames, dead, tare = _frames(project, source, rate, given or {}, engine)
    inputs = [config, Path(source), *files_of(project.input)]
    if out:
        check_result(out, "live", inputs)

    def warn(fault: str) -> None:
        print_error(f"warning: {InputError(name, '', fault)}")

    feed, page, record, report = _shown(project, name, engine, dead)
    feed.tare, feed.keep = tare, record.keep if out else None
    sensor = project.array.sensor
    stopped = None
    try:
        with serving(page, feed, port) as address:
            with progress(f"getting the {engine.value} engine ready"):
                record(np.zeros((1, sensor.rows, sensor.columns)))  # the slowest one
            typer.echo(f"{address} shows {name} by the {engine.value} engine; Ctrl-C ends it")
            threading.Thread(target=feed.read, args=(frames, warn), daemon=True).start()
            feed.run()
            _serve_the_rest(feed, stay, one=out is None)
    except Stopped as signalled:
        stopped = signalled
    typer.echo(f"tfra live: {feed.totals()}")
    if out:
        _write(out, record, report, engine, project, inputs)
    if stopped and stopped.number != signal.SIGINT:
        raise stopped


def _serve_the_rest(feed: Feed, stay: bool, *, one: bool) -> None:
    """Wait until pages have the last frame, at least ``one``, or for ever."""
    if stay or (one and not feed.is_read):
        typer.echo(f"{feed.source} has ended; " + ("Ctrl-C ends" if stay else "a page or Ctrl-C ends") + " the command")
    if stay:
        while True:
            signal.pause()
    feed.wait_for_pages(one=one)


def _write(
    out: Path,
    record: Record[Any],
    report: Callable[[Floats, Any], ArrayReport | SkinReport],
    engine: Engine,
    project: Project,
    inputs: list[Path],
) -> None:
    """Write what was kept; raises ``InputError`` if nothing was."""
    from tfra.recordings.results import write_result

    kept = record.kept()
    if kept is None:
        raise InputError(out, "", "is not written: there was no frame")
    recording, result = kept
    made = report(recording.frames, result).estimate(recording, engine.value, project.text())
    write_result(out, made, "live", inputs)
    typer.echo(f"{out}: {len(recording)} frames by the {engine.value} engine")


def _shown(project: Project, source: str, engine: Engine, dead: Bools | None) -> _Shown:
    """What shows the frames of the project's array, whose ``dead`` taxels are marked, from ``source``."""
    from tfra.model import tfra
    from tfra.model.skin import result
    from tfra.recordings.record import Record
    from tfra.view.page import live_feed, render_live
    from tfra.view.skin_page import live_skin_feed, render_skin_live

    if project.skin:
        skin, contacts = project.skin, skin_estimator(engine, project, project.skin)

        def found(stress: Floats) -> SkinResult:
            return contacts(taken(engine, project, stress, source))

        of_skin = Record(found, result.joined)
        feed = live_skin_feed(source, skin, of_skin)
        page = render_skin_live(feed, engine.value, skin, dead)
        return _Shown(feed, page, of_skin, lambda _, found: SkinReport(found))
    model = estimator(engine, project)

    def estimate(stress: Floats) -> Result:
        return model(taken(engine, project, stress, source))

    record = Record(estimate, tfra.joined)
    feed = live_feed(source, engine.value, project.design, record, project.design.sweeps)
    return _Shown(feed, render_live(feed, engine.value, project.design, dead), record, ArrayReport)


def _frames(project: Project, source: str, rate: float | None, given: Given, engine: Engine) -> _Source:
    """Open ``source``.

    Raises ``InputError`` for a missing source or an unreadable recording.
    """
    from tfra.recordings.lines import FrameLines, due, replayed
    from tfra.recordings.streams import is_stream, open_stream

    def check(stress: Floats) -> None:
        if engine not in DOUBLE:
            codes(project, stress, "line")

    if is_stream(source):
        if rate is not None:
            raise InputError("tfra live", "--rate", "is for recordings only: a stream has its own rate")
        project = for_stream(project, given, "live")
        lines = FrameLines(project.array.sensor, project.array.adc, project.input)
        stream = open_stream(source)
        return _Source(project, stream.name, lines.frames(stream.lines(), check), ~lines.intake.alive, lines.intake)
    file = Path(source)
    project = for_recording(project, file, given, "live")
    recording = frames_at(file, project)
    if engine not in DOUBLE:
        codes(project, recording.frames, file)
    return _Source(project, file.name, replayed(recording.frames, due(recording, rate)), recording.dead)
