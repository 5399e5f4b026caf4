"""``tfra paper``: the paper's tables and figures, recomputed."""

import typer

from tfra.cli.common import Json, OutDirectory, print_json, progress
from tfra.runtime.errors import require


def paper(out: OutDirectory, json: Json = False) -> None:
    """Recompute the paper's tables and figures: index.html with all of them, and CSV and SVG files."""
    require("tfra paper", "paper", "matplotlib")
    from tfra.paper.report import PIECES, REPEATS, report

    with progress("computing tables and figures", PIECES) as advance:
        summary = report(out, REPEATS, advance)
    if json:
        print_json(summary)
    else:
        typer.echo(f"{out}: open index.html; times are in fig9.html")
