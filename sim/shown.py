"""The result of a verification, as tables in a terminal or as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

from rich.console import Console
from rich.table import Column
from rich.table import Table as Printed

from tfra.model.metrics import ERRORS
from tfra.model.tfra import Status
from tfra.recordings.facts import status_label
from tfra.report.html import bars, contents, document, grid, row
from tfra.sim.report import Report

AGAINST = {"model": "model, every bit", "float": "double precision", "contact": "true values"}
"""References of frames, and their names in tables."""


@dataclass(frozen=True)
class Table:
    """Rows under a header; the columns ``names`` hold text, the others numbers.  ``name`` is the id on the page."""

    name: str
    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    names: frozenset[int] = frozenset({0})


def render(report: Report, console: Console) -> None:
    """Print the tables and the failures."""
    for table in _tables(report):
        console.print(_printed(table))
    for line in _complaints(report):
        console.print(line, style="red", highlight=False)
    style = "green" if report.passed else "bold red"
    console.print(f"{report.name}: {_verdict(report)}", style=style, highlight=False)


def page(report: Report) -> str:
    """A self-contained page: the verdict, then the tables."""
    tables = list(_tables(report))
    verdict = (
        f"{_verdict(report).capitalize()}: {report.compared:,} of {report.words:,} words of {report.frames:,} frames "
        f"were compared, {report.mismatches:,} differ."
    )
    parts = [f'<p class="answer{"" if report.passed else " failed"}">{escape(verdict)}</p>']
    parts += [f'<p class="answer failed">{escape(line)}</p>' for line in _complaints(report)]
    parts += [contents({table.name: table.title for table in tables}), *(_shown(table, report) for table in tables)]
    return document(f"{report.name}: the core against its model", parts, "")


def _tables(report: Report) -> Iterator[Table]:
    yield _summary(report)
    if report.accounts:
        yield _accounts(report)
    if report.against_float:
        yield _float(report)
    if report.against_contact:
        yield _contact(report)


def _verdict(report: Report) -> str:
    return "every bit equals the model" if report.passed else "FAILED"


def _complaints(report: Report) -> Iterator[str]:
    if report.first:
        yield f"first mismatch: {report.first}"
    yield from (f"stream rule broken: {violation}" for violation in report.violations)


def _printed(table: Table) -> Printed:
    columns = (
        Column(title, justify="left" if place in table.names else "right") for place, title in enumerate(table.header)
    )
    printed = Printed(*columns, title=table.title, show_header=any(table.header))
    for cells in table.rows:
        printed.add_row(*cells)
    return printed


def _shown(table: Table, report: Report) -> str:
    drawn = _status_bars(report) if table.name == "summary" else ""
    rows = (row(cells, table.names) for cells in table.rows)
    heading = f'<h2 id="{table.name}">{escape(table.title)}</h2>'
    return f"{heading}{grid(table.title, table.header, [rows], table.names)}{drawn}"


def _status_bars(report: Report) -> str:
    """The number of frames with each status: the coverage of the stimuli."""
    found = [(_reason(name), count) for name, count in report.status.items() if count]
    every = max(report.frames, 1)
    return bars("Frames by status", [(name, count / every, f"{count:,} frames") for name, count in found])


def _summary(report: Report) -> Table:
    frames = ", ".join(f"{count} {kind}" for kind, count in report.kinds.items())
    times = report.timing
    found = ", ".join(f"{count} {_reason(name)}" for name, count in report.status.items() if count)
    rows = (
        ("frames", f"{report.frames} ({frames})"),
        ("words compared", f"{report.compared} of {report.words}"),
        ("mismatches", str(report.mismatches)),
        ("latency / cycles", _against(times.latency, times.design_latency)),
        ("interval / cycles", _against(times.interval, times.design_interval)),
        ("status", found),
    )
    title = f"{report.name} on {report.simulator}, seed {report.seed}"
    return Table("summary", title, ("", ""), rows, frozenset({0, 1}))


def _accounts(report: Report) -> Table:
    rows = [
        (
            account.kind,
            str(account.frames),
            AGAINST[account.against],
            str(account.compared),
            ", ".join(f"{count} {_reason(name)}" for name, count in account.left_out.items()),
        )
        for account in report.accounts
    ]
    header = ("frames", "number", "compared with", "compared", "left out")
    return Table("frames", "Frames", header, rows, frozenset({0, 2, 4}))


def _float(report: Report) -> Table:
    found = list(report.against_float.values())
    equal = [f"{100 * e.equal_index:.1f} %" for e in found if e.equal_index is not None]
    apart = [str(e.index_distance) for e in found if e.index_distance is not None]
    rows = [
        *([("equal sweep index", *equal), ("sweep index, steps apart", *apart)] if equal else []),
        *((name, *(f"{e.largest[key]:.3g}" for e in found)) for key, name in ERRORS.items()),
    ]
    header = ("largest error", *(f"{kind} frames" for kind in report.against_float))
    return Table("float", "The core against double precision on the same codes", header, rows)


def _contact(report: Report) -> Table:
    assert report.against_contact is not None
    found = report.against_contact
    rows = [(name, f"{found.median[key]:.3g}", f"{found.largest[key]:.3g}") for key, name in ERRORS.items()]
    header = ("error", f"median of {found.frames}", f"largest of {found.frames}")
    return Table("contact", "The core against the contacts' true values", header, rows)


def _reason(name: str) -> str:
    """Status bits, their absence and other reasons as text."""
    if name in Status.__members__:
        return status_label(Status[name])
    return "without status" if name == "none" else name.replace("_", " ")


def _against(measured: int | None, stated: int | None) -> str:
    shown = ["not measured" if measured is None else str(measured)]
    if stated is not None:
        shown.append(f"design: {stated}")
    return ", ".join(shown)
