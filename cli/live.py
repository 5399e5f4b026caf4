"""``tfra live``: forces of arriving frames, in a browser."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tfra.cli.common import Config, progress
from tfra.cli.inputs import Given, for_recording, for_stream, frames_at, reads_recording
from tfra.cli.messages import print_error
from tfra.codegen.config.core import check_core
from tfra.engines import DOUBLE, Engine, codes, estimator, skin_estimator
from tfra.runtime.errors import InputError, require

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.model.arrays import Floats
    from tfra.model.skin.result import SkinResult
    from tfra.model.tfra import Result
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


@reads_recording
def live(
    config: Config,
    source: Source,
    engine: LiveEngine = Engine.FLOAT,
    rate: Rate = None,
    port: Port = 8347,
    given: Given | None = None,
) -> None:
    """Show forces in a browser as frames arrive, from a stream of text, one frame a line, or from a recording.

    Frames that the engine or the browser has no time for are dropped. Ctrl-C ends it.
    """
    require("tfra live", "view", "plotly")
    import numpy as np

    from tfra.codegen.config.read import load
    from tfra.runtime.processes import Stopped
    from tfra.view.server import serving

    if rate is not None and not 0 < rate <= 1e6:
        raise InputError("tfra live", "--rate", f"more than 0 frames a second are needed, up to 1e6, got {rate:g}")
    project = load(config)
    if engine not in DOUBLE:
        check_core(project)  # before a stream is opened
    project, name, frames = _frames(project, source, rate, given or {}, engine)

    def warn(fault: str) -> None:
        print_error(f"warning: {InputError(name, '', fault)}")

    feed, page, estimate = _shown(project, name, engine)
    sensor = project.array.sensor
    try:
        with serving(page, feed, port) as address:
            with progress(f"getting the {engine.value} engine ready"):
                estimate(np.zeros((1, sensor.rows, sensor.columns)))  # the slowest one
            typer.echo(f"{address} shows {name} by the {engine.value} engine; Ctrl-C ends it")
            threading.Thread(target=feed.read, args=(frames, warn), daemon=True).start()
            feed.run()
    except Stopped as stopped:
        if stopped.number != signal.SIGINT:
            raise
        typer.echo(f"tfra live: {feed.totals()}")


def _shown(project: Project, source: str, engine: Engine) -> tuple[Feed, str, Callable[[Floats], object]]:
    """The feed of the page for the project's array, the page, and the engine as a function of stress."""
    from tfra.recordings.frames import front_end
    from tfra.view.page import live_feed, render_live
    from tfra.view.skin_page import live_skin_feed, render_skin_live

    dead = ~front_end(Path(source), project.array.sensor, project.array.adc, project.input, None).alive
    if project.skin:
        skin, contacts = project.skin, skin_estimator(engine, project, project.skin)

        def found(stress: Floats) -> SkinResult:
            return contacts(stress if engine in DOUBLE else codes(project, stress, source))

        feed = live_skin_feed(source, skin, found)
        return feed, render_skin_live(feed, engine.value, skin, dead), found
    model = estimator(engine, project)

    def estimate(stress: Floats) -> Result:
        return model(stress if engine in DOUBLE else codes(project, stress, source))

    feed = live_feed(source, engine.value, project.design, estimate, project.design.sweeps)
    return feed, render_live(feed, engine.value, project.design, dead), estimate


def _frames(
    project: Project, source: str, rate: float | None, given: Given, engine: Engine
) -> tuple[Project, str, Iterator[Floats | str]]:
    """Return the project with the ``input`` of ``source``, its name, and its frames in Pa, or faults of its lines.

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
        return project, stream.name, lines.frames(stream.lines(), check)
    file = Path(source)
    project = for_recording(project, file, given, "live")
    recording = frames_at(file, project)
    if engine not in DOUBLE:
        codes(project, recording.frames, file)
    return project, file.name, replayed(recording.frames, due(recording, rate))
