"""The page of results: one self-contained file, whose script shows any of its frames."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from enum import IntFlag
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np
from plotly.offline import get_plotlyjs

from tfra.model.arrays import Bools, Floats
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status
from tfra.recordings.facts import MEANINGS, RESULTANT_ALONE, WITHOUT_FORCE, Facts, Spread, facts, status_label
from tfra.report.colours import STRESS
from tfra.report.html import data_script, document, text, wide
from tfra.runtime.errors import InputError
from tfra.view.feed import SECONDS, Feed
from tfra.view.pack import Chosen, frame_bytes, references, result, sweep_bytes, times
from tfra.view.resultfile import Recorded, References, describe

MOST = 5
"""Results and files of reference values that colours and dashes distinguish."""

BESIDE = 3
"""Columns of numbers that fit beside the maps."""

OBLONG = 1.5
"""Maps of arrays with a larger ratio of width to height stand below each other."""

TITLE = "Contact forces"

LIVE_TITLE = "Contact forces, live"

_DRAWING = (
    *("numbers.js", "data.js", "map.js", "surface.js", "looks.js"),
    *("charts.js", "controls.js", "saved.js", "page.js"),
)
"""Scripts that draw any page and handle its controls."""

_SPEEDS = (1, 5, 10, 25, 50, 100, 250, 1000)
"""Frames a second."""

_TICKS = (-1, -0.5, 0, 0.5, 1)
"""Places on the bar of colours, in shares of its half."""

_ROWS = {
    "phi": "φ / °",
    "mu": "μ",
    **{f"mu_{axis}": f"μ<sub>{axis}</sub>" for axis in "xy"},
    "f": "|F| / N",
    **{f"f_{axis}": f"F<sub>{axis}</sub> / N" for axis in "xyz"},
    "c": "c (x, y) / mm",
    "t": "t (x, y) / mm",
    "uncertainty": "uncertainty, % of |F<sub>z</sub>|",
    "residual": "residual / %",
    "status": "status",
}
"""Rows of the table of a frame; the page hides one that no result has."""

_TAXEL_ROWS = {
    "taxel-stress": "stress / <span data-unit=stress></span>",
    "taxel-left": "residual / <span data-unit=stress></span>",
    **{f"taxel-{axis}": f"f<sub>{axis}</sub> / <span data-unit=force></span>" for axis in "xyz"},
}


def render(results: Sequence[Recorded], known: Sequence[References], chosen: Chosen) -> str:
    """The page of ``results`` and the references ``known`` of their frames; depends on its arguments only."""
    labels = _labels(results, known)
    named, true = labels[: len(results)], labels[len(results) :]
    data = {
        **described(results[0].design.sensor, Status),
        "start": chosen.shown.start,
        "step": chosen.shown.step,
        "sweeps": chosen.sweeps,
        "time": times(list(results), chosen),
        "results": [
            _searched(one.design, label, one.dead) | result(one, chosen)
            for one, label in zip(results, named, strict=True)
        ],
        "references": [
            {"label": label, "values": references(one, chosen)} for one, label in zip(known, true, strict=True)
        ],
    }
    content = {
        "STATE": "",
        "SUMMARY": "\n".join(_summary(results, named, chosen)),
        "CONTROLS": controls(len(chosen.shown)),
    }
    body = _filled(results[0].design, named, true, content)
    parts = [body, *scripts(data, "(() =>", ("arrays.js", "given.js", *_DRAWING, "recorded.js"))]
    return document(TITLE, parts, resource("page.css"))


def live_feed(
    source: str, engine: str, design: Design, estimate: Callable[[Floats], Result], swept: bool = True
) -> Feed:
    """Frames of ``source`` on their way to a live page; ``swept`` as for ``Recorded``."""

    def packed(stress: Floats) -> dict[str, Any]:
        recorded = Recorded(source, engine, design, estimate(stress), stress, None, swept)
        return result(recorded, Chosen.all(len(stress)))

    return Feed(source, packed, frame_bytes(design.sensor.taxels) + swept * sweep_bytes(design.search.steps))


def render_live(feed: Feed, engine: str, design: Design, dead: Bools | None = None) -> str:
    """The live page of ``feed``, which requests frames from its server; ``dead`` as for ``Recorded``."""
    label = f"{feed.source} ({engine})"
    data = {
        **described(design.sensor, Status),
        "sweeps": 1,
        "seconds": SECONDS,
        "most": feed.most,
        "results": [_searched(design, label, dead)],
        "references": [],
    }
    body = _filled(design, [label], [], live_parts(f"{describe(design.sensor)}.") | {"CONTROLS": controls()})
    parts = [body, *scripts(data, "(async () =>", ("arrays.js", "feed.js", *_DRAWING, "live.js"))]
    return document(LIVE_TITLE, parts, resource("page.css") + resource("live.css"))


def require_few(results: Sequence[Recorded], known: Sequence[References]) -> None:
    """Raise ``InputError`` for more files than a page can distinguish."""
    if len(results) > MOST or len(known) > 1:
        given = f"{len(results)} and {len(known)}"
        raise InputError("tfra view", "RESULT.npz", f"at most {MOST} results and 1 file of references, got {given}")


def resource(name: str) -> str:
    """The text of a file of this folder."""
    return files("tfra.view").joinpath(name).read_text(encoding="utf-8")


def controls(count: int = 0) -> str:
    """Slider and buttons of a recording of ``count`` frames, which plays; 0: of live frames."""
    speeds = "".join(f"<option{' selected' * (speed == 25)}>{speed}</option>" for speed in _SPEEDS)
    choice = f'<label>Speed <select id="speed">{speeds}</select> frames/s</label>'
    return filled("controls.html", {"LAST": str(max(0, count - 1)), "SPEED": choice if count else ""})


def legend() -> str:
    """The bar of a map's colours."""
    return filled("legend.html", {"TICKS": "".join(f'<span data-share="{share}"></span>' for share in _TICKS)})


def live_parts(sensor: str) -> dict[str, str]:
    """What a live page has around its frames: their state, and counts beside the ``sensor``."""
    return {"STATE": resource("live.html"), "SUMMARY": filled("counts.html", {"SENSOR": escape(sensor)})}


def places(dead: Bools | None) -> list[int]:
    """The taxels that are dead, counted along rows."""
    return [] if dead is None else [int(taxel) for taxel in np.flatnonzero(dead)]


def described(sensor: SensorArray, flags: Iterable[IntFlag]) -> dict[str, Any]:
    """Data for the scripts of any page; ``flags`` are the bits of a status."""
    return {
        "colours": STRESS,
        "rows": sensor.rows,
        "columns": sensor.columns,
        "pitch": [1e3 * sensor.pitch_x, 1e3 * sensor.pitch_y],
        "resultantAlone": RESULTANT_ALONE,
        "statuses": [{"bit": int(flag), "words": status_label(flag)} for flag in flags],
        "bits": {
            "noContact": int(Status.NO_CONTACT),
            "noDirection": int(Status.NO_DIRECTION),
            "implausible": int(Status.IMPLAUSIBLE),
            "withoutForce": sum(int(flag) for flag in WITHOUT_FORCE),
        },
    }


def _searched(design: Design, label: str, dead: Bools | None) -> dict[str, Any]:
    """Data for the scripts about a result, without its frames."""
    search = design.search
    tolerance = search.tolerance * design.adc.lsb
    return {"label": label, "steps": search.steps, "tolerance": tolerance, "dead": places(dead)}


def _filled(design: Design, named: Sequence[str], true: Sequence[str], more: dict[str, str]) -> str:
    """The body of a page of results ``named`` and references ``true``; ``more`` are the parts that differ by kind."""
    sensor, labels = design.sensor, [*named, *true]
    parts = more | {
        "MAPS": "".join(
            f'<figure><figcaption>{escape(label)} <b class="flag">implausible</b></figcaption>'
            f'<canvas id="map-{n}" role="img"></canvas></figure>'
            for n, label in enumerate(named)
        ),
        "LEGEND": legend(),
        "CURVES": resource("curves.html"),
        "SHAPE": "oblong" if sensor.size_x > OBLONG * sensor.size_y else "",
        "NUMBERS-CLASS": "numbers many" if len(labels) > BESIDE else "numbers",
        "NUMBERS": _numbers(labels, _ROWS, "This frame"),
        "TAXEL": _numbers(named, _TAXEL_ROWS, "This taxel"),
        "ROWS": str(sensor.rows - 1),
        "COLUMNS": str(sensor.columns - 1),
        "DETAILS": "".join(f'<option value="{n}">{escape(label)}</option>' for n, label in enumerate(named)),
    }
    return filled("body.html", parts)


def filled(name: str, parts: dict[str, str]) -> str:
    """The text of a file of this folder with its ``parts`` in place of their names."""
    body = resource(name)
    for place, content in parts.items():
        body = body.replace(f"<!--{place}-->", content).replace(f'"{place}"', f'"{content}"')
    return body


def scripts(data: dict[str, Any], opened: str, names: Sequence[str]) -> Iterator[str]:
    """The data and the scripts, in a function that begins with ``opened``."""
    yield data_script("data", data)
    yield f"<script>{get_plotlyjs()}</script>"
    yield f'<script>\n{opened} {{\n"use strict";\n' + "\n".join(map(resource, names)) + "})();\n</script>"


def _labels(results: Sequence[Recorded], known: Sequence[References]) -> list[str]:
    """A distinct name for each file."""
    labels = [f"{one.name} ({one.engine})" for one in results] + [f"{one.name} (reference)" for one in known]
    return [label if labels.count(label) == 1 else f"{label} #{n}" for n, label in enumerate(labels, 1)]


def _summary(results: Sequence[Recorded], labels: Sequence[str], chosen: Chosen) -> Iterator[str]:
    summaries = [facts(one.stress, one.found) for one in results]
    yield f'<h2>Summary</h2><p class="note">{escape(describe(results[0].design.sensor))}. {escape(str(chosen))}</p>'
    rows = {
        "engine": [one.engine for one in results],
        "frames": [f"{fact.frames:,}" for fact in summaries],
        "contact": [f"{100 * fact.contact / fact.frames:.1f} %" for fact in summaries],
        "φ, median": [_median(fact.phi_deg, ".1f", "°") for fact in summaries],
        "μ, median": [_median(fact.mu, ".3f", "") for fact in summaries],
        "|F|, median": [_median(fact.force_n, ".3g", " N") for fact in summaries],
        "tension, of the stress": [f"{fact.tension_percent_of_stress:.1f} %" for fact in summaries],
    }
    if any(fact.threshold_percent for fact in summaries):
        rows["uncertainty, median"] = [_median(fact.uncertainty_percent, ".3g", " % of |F_z|") for fact in summaries]
        rows["implausible over"] = [_number(fact.threshold_percent, ".3g", " % of |F_z|") for fact in summaries]
    lines = "".join(
        f"<tr><th scope=row>{name}</th>{''.join(f'<td>{text(cell)}</td>' for cell in cells)}</tr>"
        for name, cells in rows.items()
    )
    yield f'<div id="summary">{_table(labels, lines, "Summary of all frames")}</div>'
    notes = [f"{label}: {note}" for label, fact in zip(labels, summaries, strict=True) for note in _notes(fact)]
    if notes:
        yield f'<ul class="note" id="notes">{"".join(f"<li>{escape(note)}</li>" for note in notes)}</ul>'


def _notes(fact: Facts) -> Iterator[str]:
    """Lines about the statuses of a result's frames."""
    for flag, count in fact.statuses.items():
        if count:
            yield f"{count:,} of {fact.frames:,} frames {status_label(flag)}: {MEANINGS[flag]}"


def _median(spread: Spread | None, digits: str, unit: str) -> str:
    return _number(spread.median if spread else None, digits, unit)


def _number(value: float | None, digits: str, unit: str) -> str:
    return "–" if value is None else f"{value:{digits}}{unit}"


def _numbers(labels: Sequence[str], rows: dict[str, str], caption: str) -> str:
    cells = "<td></td>" * len(labels)
    lines = "".join(f'<tr data-row="{key}"><th scope=row>{name}</th>{cells}</tr>' for key, name in rows.items())
    return _table(labels, lines, caption)


def _table(labels: Sequence[str], lines: str, caption: str) -> str:
    head = "".join(f"<th scope=col>{escape(label)}</th>" for label in labels)
    first = f'<td class="name"><strong>{caption}</strong></td>'
    return wide(caption, f"<table><thead><tr>{first}{head}</tr></thead><tbody>{lines}</tbody></table>")
