"""``tfra view``: an interactive page of results."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tfra.cli.common import Json, print_json
from tfra.runtime.errors import InputError, quoted, require

if TYPE_CHECKING:
    from tfra.view.pack import Chosen

Results = Annotated[
    list[Path],
    typer.Argument(
        metavar="RESULT.npz...",
        help="Results of tfra estimate, or one of a skin; optionally frames with reference values.",
    ),
]
Out = Annotated[Path, typer.Option(metavar="page.html", help="Output file.")]
Every = Annotated[int, typer.Option(min=1, metavar="N", help="Show every Nth frame.")]
Frames = Annotated[str, typer.Option("--frames", metavar="A:B", help="Show frames A to B - 1, counted from 0.")]


def view(results: Results, out: Out, every: Every = 1, frames: Frames = ":", json: Json = False) -> None:
    """Write an interactive page of results: stress, forces, friction and direction of every frame, or contact.

    The page is one self-contained file; open it in a browser.
    """
    require("tfra view", "view", "plotly")
    from tfra.runtime.outputs import check_file, write_text

    check_file(out, ".html", "view", results)
    text, chosen = _page(results, lambda count: _selected(frames, every, count))
    write_text(out, text, "view")
    size = out.stat().st_size
    if json:
        shown = {"first": chosen.shown.start, "step": chosen.shown.step, "count": len(chosen.shown)}
        print_json(
            {"out": str(out), "bytes": size, "frames": chosen.total, "shown": shown, "sweeps_every": chosen.sweeps}
        )
    else:
        typer.echo(f"{out}: {size / 1e6:.1f} MB. {chosen}")


def _page(paths: list[Path], selected: Callable[[int], range]) -> tuple[str, Chosen]:
    """The page of the results at ``paths``, and the frames on it, of those ``selected`` by their number."""
    from tfra.view.pack import Chosen
    from tfra.view.page import render, require_few
    from tfra.view.resultfile import read_all, require_results
    from tfra.view.skin_page import chosen_frames, render_skin
    from tfra.view.skinfile import is_of_skin, read_skin

    require_results(paths)
    if any(is_of_skin(path) for path in paths):
        if len(paths) > 1:
            raise InputError("tfra view", "RESULT.npz", f"the result of a skin has a page of its own, got {len(paths)}")
        skin = read_skin(paths[0])
        shown = chosen_frames(skin, selected(len(skin.stress)))
        return render_skin(skin, shown), shown
    recorded, known = read_all(paths)
    require_few(recorded, known)
    chosen = Chosen.of(recorded, selected(len(recorded[0].stress)))
    return render(recorded, known, chosen), chosen


def _selected(text: str, every: int, count: int) -> range:
    """The frames that ``A:B`` and ``every`` choose of ``count``; raises ``InputError`` for none of them."""
    first, colon, end = text.partition(":")
    if not colon or not all(part == "" or (part.isascii() and part.isdigit()) for part in (first, end)):
        raise InputError("tfra view", "--frames", f"A:B is needed, whole numbers or nothing, got {quoted(text)}")
    wanted = range(int(first or 0), min(count, int(end or count)), every)
    if not wanted:
        raise InputError("tfra view", "--frames", f"{quoted(text)} selects none of the frames 0 to {count - 1}")
    return wanted
