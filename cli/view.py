"""``tfra view``: an interactive page of results."""

from pathlib import Path
from typing import Annotated

import typer

from tfra.cli.common import Json, print_json
from tfra.runtime.errors import InputError, quoted, require

Results = Annotated[
    list[Path],
    typer.Argument(metavar="RESULT.npz...", help="Results of tfra estimate; optionally frames with reference values."),
]
Out = Annotated[Path, typer.Option(metavar="page.html", help="Output file.")]
Every = Annotated[int, typer.Option(min=1, metavar="N", help="Show every Nth frame.")]
Frames = Annotated[str, typer.Option("--frames", metavar="A:B", help="Show frames A to B - 1, counted from 0.")]


def view(results: Results, out: Out, every: Every = 1, frames: Frames = ":", json: Json = False) -> None:
    """Write an interactive page of results: stress, forces, friction and direction of every frame.

    The page is one self-contained file; open it in a browser.
    """
    require("tfra view", "view", "plotly")
    from tfra.runtime.outputs import check_file, write_text
    from tfra.view.pack import Chosen
    from tfra.view.page import render, require_few
    from tfra.view.resultfile import read_all

    check_file(out, ".html", "view", results)
    recorded, known = read_all(results)
    require_few(recorded, known)
    chosen = Chosen.of(recorded, _selected(frames, every, len(recorded[0].stress)))
    write_text(out, render(recorded, known, chosen), "view")
    size = out.stat().st_size
    if json:
        shown = {"first": chosen.shown.start, "step": chosen.shown.step, "count": len(chosen.shown)}
        print_json(
            {"out": str(out), "bytes": size, "frames": chosen.total, "shown": shown, "sweeps_every": chosen.sweeps}
        )
    else:
        typer.echo(f"{out}: {size / 1e6:.1f} MB. {chosen}")


def _selected(text: str, every: int, count: int) -> range:
    """The frames that ``A:B`` and ``every`` choose of ``count``; raises ``InputError`` for none of them."""
    first, colon, end = text.partition(":")
    if not colon or not all(part == "" or (part.isascii() and part.isdigit()) for part in (first, end)):
        raise InputError("tfra view", "--frames", f"A:B is needed, whole numbers or nothing, got {quoted(text)}")
    wanted = range(int(first or 0), min(count, int(end or count)), every)
    if not wanted:
        raise InputError("tfra view", "--frames", f"{quoted(text)} selects none of the frames 0 to {count - 1}")
    return wanted
