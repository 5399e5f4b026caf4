"""``tfra paper``: every table and figure, in one directory."""

from __future__ import annotations

import csv
import io
import json
import platform
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tfra.paper import page, tables
from tfra.paper.fig2 import fig2
from tfra.paper.fig4 import fig4
from tfra.paper.fig5 import fig5
from tfra.paper.fig8 import fig8
from tfra.paper.fig9 import fig9
from tfra.paper.picture import Picture, looks, write
from tfra.paper.setups import setups
from tfra.paper.sptfra import sptfra
from tfra.paper.surfaces import surfaces
from tfra.runtime.outputs import output_directory
from tfra.runtime.ownership import MANIFEST

PIECES = 11
"""How often ``report`` tells of progress: two tables, seven figures, two contacts of Fig. 9."""

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
    made = []
    for name, setup in zip(("table1", "table2"), contacts, strict=True):
        made.append(tables.make(name, setup))
        _write_table(made[-1], folder)
        advance(1)
    pictures = []
    for picture in _pictures():
        write(picture, folder)
        pictures.append(picture)
        advance(1)
    timing = fig9(contacts, repeats, advance)
    write(timing, folder)
    (folder / "fig9.html").write_text(page.alone(folder, timing, versions), encoding="utf-8")
    (folder / "index.html").write_text(page.index(folder, made, pictures, versions), encoding="utf-8")
    return _summary(made, versions, sorted(path.name for path in folder.iterdir()))


def _pictures() -> Iterator[Picture]:
    """Every figure whose numbers are the same in every run."""
    hertz, rectangle = contacts = setups()
    yield fig2(hertz)
    yield fig4(hertz)
    yield fig5(contacts)
    yield surfaces("fig6", hertz)
    yield surfaces("fig7", rectangle)
    yield fig8(contacts)
    yield sptfra(contacts)


def _write_table(table: tables.Table, folder: Path) -> None:
    parts = {"": (tables.HEADER, table.rows), "_maxima": (tables.MAXIMA_HEADER, table.maxima)}
    for suffix, (header, rows) in parts.items():
        stream = io.StringIO()
        csv.writer(stream, lineterminator="\n").writerows([header, *rows])
        (folder / f"{table.name}{suffix}.csv").write_text(stream.getvalue(), encoding="utf-8")


def _summary(made: Sequence[tables.Table], versions: dict[str, str], files: list[str]) -> dict[str, Any]:
    percent = {table.name: {name: asdict(e) for name, e in table.largest.items()} for table in made}
    plain = {table.name: table.plain for table in made}
    return {
        "generator": f"tfra {version('tfra')}",
        "doi": "10.1016/j.mechatronics.2023.103070",
        "largest_errors_by_the_papers_measures_percent": _rounded(percent),
        "largest_errors": _rounded(plain),
        "not_reproducible": ["fig9.csv", "fig9.html", "fig9.png", "fig9.svg", MANIFEST],  # which has their hashes
        "versions": versions,
        "files": files,
    }


def _rounded(errors: dict[str, dict[str, dict[str, float]]]) -> dict[str, dict[str, dict[str, float]]]:
    return {t: {m: {k: round(v, 4) for k, v in e.items()} for m, e in es.items()} for t, es in errors.items()}
