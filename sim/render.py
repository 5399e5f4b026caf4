"""The report of a verification, as tables in a terminal or as a page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from tfra.model.metrics import ERRORS
from tfra.model.tfra import Status
from tfra.recordings.facts import status_label
from tfra.report.html import Section, bars, paragraph
from tfra.report.html import page as html_page
from tfra.report.table import Table
from tfra.sim.report import Report
from tfra.sim.skin_report import SkinReport

if TYPE_CHECKING:
    from rich.console import Console

AGAINST = {"model": "model, every bit", "float": "double precision", "contact": "true values"}
"""References of frames, and their names in tables."""


def render(report: Report | SkinReport, console: Console) -> None:
    """Print the tables and the failures."""
    for table in _tables(report).values():
        console.print(table.rich())
    for line in _complaints(report):
        console.print(line, style="red", highlight=False)
    style = "green" if report.passed else "bold red"
    console.print(f"{report.name}: {_verdict(report)}", style=style, highlight=False)


def page(report: Report | SkinReport) -> str:
    """A self-contained page: the verdict, then the tables."""
    kind = "answer" if report.passed else "answer failed"
    verdict = (
        f"{_verdict(report).capitalize()}: {report.compared:,} of {report.words:,} words of {report.frames:,} frames "
        f"were compared, {report.mismatches:,} differ."
    )
    opening = [paragraph(verdict, kind), *(paragraph(line, "answer failed") for line in _complaints(report))]
    sections = [Section(name, table.title, [table.html()]) for name, table in _tables(report).items()]
    if isinstance(report, Report):
        seen = ((name, count) for name, count in report.status.items() if count)
        rows = [(_reason(name), count / report.frames, f"{count:,} frames") for name, count in seen]
        sections.insert(1, Section("status", "Frames by status", [bars("Frames by status", rows)]))
    return html_page(f"{report.name}: the core against its model", opening, sections)


def _tables(report: Report | SkinReport) -> dict[str, Table]:
    """Tables by their ids on the page."""
    if isinstance(report, SkinReport):
        return {"summary": report.table()}
    tables = {"summary": _summary(report)}
    if report.accounts:
        tables["frames"] = _accounts(report)
    if report.against_float:
        tables["float"] = _float(report)
    if report.against_contact:
        tables["contact"] = _contact(report)
    return tables


def _verdict(report: Report | SkinReport) -> str:
    return "every bit equals the model" if report.passed else "FAILED"


def _complaints(report: Report | SkinReport) -> Iterator[str]:
    if report.first:
        yield f"first mismatch: {report.first}"
    yield from (f"stream rule broken: {violation}" for violation in report.violations)


def _summary(report: Report) -> Table:
    times = report.timing
    rows = [
        ("frames", f"{report.frames} ({_counts(report.kinds)})"),
        ("words compared", f"{report.compared} of {report.words}"),
        ("mismatches", report.mismatches),
        ("latency / cycles", _measured(times.latency, times.design_latency)),
        ("interval / cycles", _measured(times.interval, times.design_interval)),
        ("status", _counts(report.status)),
    ]
    return Table(f"{report.name} on {report.simulator}, seed {report.seed}", ("", ""), rows, (0, 1))


def _accounts(report: Report) -> Table:
    rows = [
        (account.kind, account.frames, AGAINST[account.against], account.compared, _counts(account.left_out))
        for account in report.accounts
    ]
    return Table("Frames", ("frames", "number", "compared with", "compared", "left out"), rows, (0, 2, 4))


def _float(report: Report) -> Table:
    kinds = report.against_float.values()
    equal = [f"{100 * e.equal_index:.1f} %" for e in kinds if e.equal_index is not None]
    distance = [e.index_distance for e in kinds if e.index_distance is not None]
    rows = [("equal sweep index", *equal), ("sweep index, steps apart", *distance)] if equal else []
    rows += [(name, *(f"{e.largest[key]:.3g}" for e in kinds)) for key, name in ERRORS.items()]
    header = ("largest error", *(f"{kind} frames" for kind in report.against_float))
    return Table("The core against double precision on the same codes", header, rows)


def _contact(report: Report) -> Table:
    errors = report.against_contact
    assert errors is not None
    rows = [(name, f"{errors.median[key]:.3g}", f"{errors.largest[key]:.3g}") for key, name in ERRORS.items()]
    header = ("error", f"median of {errors.frames}", f"largest of {errors.frames}")
    return Table("The core against the contacts' true values", header, rows)


def _counts(numbers: dict[str, int]) -> str:
    """Numbers of frames by kind, or by status or reason, those of no frame left out."""
    return ", ".join(f"{count} {_reason(name)}" for name, count in numbers.items() if count)


def _reason(name: str) -> str:
    """Status bits, their absence and other reasons as text."""
    if name in Status.__members__:
        return status_label(Status[name])
    return "without status" if name == "none" else name.replace("_", " ")


def _measured(cycles: int | None, stated: int | None) -> str:
    measured = "not measured" if cycles is None else str(cycles)
    return measured if stated is None else f"{measured}, design: {stated}"
