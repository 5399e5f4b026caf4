"""``tfra paper``: every table and figure, in one directory."""

import csv
import io
import json
import platform
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tfra.paper import page, tables
from tfra.paper.fig5 import fig5
from tfra.paper.fig8 import fig8
from tfra.paper.fig9 import fig9
from tfra.paper.one_direction import fig2, fig4
from tfra.paper.picture import Picture, looks, write
from tfra.paper.published import PAPER, PLAIN
from tfra.paper.setups import Setup, setups
from tfra.paper.sptfra import sptfra
from tfra.paper.surfaces import surfaces
from tfra.runtime.outputs import output_directory
from tfra.runtime.ownership import MANIFEST

FIGURES: tuple[Callable[[tuple[Setup, Setup]], Picture], ...] = (
    lambda contacts: fig2(contacts[0]),
    lambda contacts: fig4(contacts[0]),
    fig5,
    lambda contacts: surfaces("fig6", contacts[0]),
    lambda contacts: surfaces("fig7", contacts[1]),
    fig8,
    sptfra,
)
"""Those whose numbers are the same in every run, in the order of the page."""

PIECES = 2 + len(FIGURES) + 2
"""Steps of the progress that ``report`` tells: two tables, the figures, two contacts of Fig. 9."""

REPEATS = 15
"""Calls that each time in Fig. 9 is the median of."""

SIDECAR = "paper.json"


def report(
    out: str | Path, repeats: int = REPEATS, advance: Callable[[int], None] = lambda pieces: None
) -> dict[str, Any]:
    """Write the report to the directory ``out`` and return what its ``paper.json`` says.

    Two runs write the same bytes, except for the times in ``fig9.*``.  Raises ``InputError`` as ``output_directory``.
    """
    versions = {"Python": platform.python_version()}
    versions |= {name: version(name) for name in ("tfra", "numpy", "scipy", "matplotlib")}
    with output_directory(out, "paper") as folder, looks():
        summary = _fill(folder, versions, repeats, advance)
        (folder / SIDECAR).write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    return summary


def _fill(folder: Path, versions: dict[str, str], repeats: int, advance: Callable[[int], None]) -> dict[str, Any]:
    """Write every table, figure and page into ``folder``, and return their summary."""
    contacts = setups()
    results = []
    for name, setup in zip(("table1", "table2"), contacts, strict=True):
        results.append(tables.build(name, setup))
        _write_table(results[-1], folder)
        advance(1)
    pictures = []
    for figure in FIGURES:
        pictures.append(figure(contacts))
        write(pictures[-1], folder)
        advance(1)
    timing = fig9(contacts, repeats, advance)
    write(timing, folder)
    (folder / "fig9.html").write_text(page.alone(folder, timing, versions), encoding="utf-8")
    (folder / "index.html").write_text(page.index(folder, results, pictures, versions), encoding="utf-8")
    return _summary(results, versions, sorted(path.name for path in folder.iterdir()))


def _write_table(table: tables.Table, folder: Path) -> None:
    parts = {"": (tables.HEADER, table.rows), "_maxima": (tables.MAXIMA_HEADER, table.maxima)}
    for suffix, (header, rows) in parts.items():
        stream = io.StringIO()
        csv.writer(stream, lineterminator="\n").writerows([header, *rows])
        (folder / f"{table.name}{suffix}.csv").write_text(stream.getvalue(), encoding="utf-8")


def _summary(results: Sequence[tables.Table], versions: dict[str, str], files: list[str]) -> dict[str, Any]:
    def worst(keys: Sequence[str]) -> dict[str, Any]:
        """By table and method, where all of these errors are known."""
        return {
            table.name: {
                method: {key: round(errors[key], 4) for key in keys}
                for method, errors in table.largest.items()
                if errors.keys() >= set(keys)
            }
            for table in results
        }

    return {
        "generator": f"tfra {version('tfra')}",
        "doi": "10.1016/j.mechatronics.2023.103070",
        "largest_errors_by_the_papers_measures_percent": worst(tuple(PAPER)),
        "largest_errors": worst(PLAIN),
        "not_reproducible": ["fig9.csv", "fig9.html", "fig9.svg", MANIFEST],  # which has their hashes
        "versions": versions,
        "files": files,
    }
