"""The page of a skin's contacts: a map with a numbered arrow a contact, a table of them, their values over the frames.

A contact keeps its number and its colour as long as it is followed.
"""

from collections.abc import Callable
from html import escape
from typing import Any

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.skin.finding import Mark
from tfra.model.skin.result import SkinResult
from tfra.model.skin.skin import Skin
from tfra.model.skin.tracking import Tracker
from tfra.model.tfra import Status
from tfra.recordings.skin_facts import skin_facts, skin_lines
from tfra.report.html import document
from tfra.view.feed import SECONDS, Feed
from tfra.view.pack import Chosen, packed, scaled
from tfra.view.page import (
    LIVE_TITLE,
    TITLE,
    controls,
    described,
    filled,
    legend,
    live_parts,
    places,
    resource,
    scripts,
)
from tfra.view.resultfile import describe
from tfra.view.skinfile import RecordedSkin

_DRAWING = ("numbers.js", "map.js", "looks.js", "controls.js", "saved.js", "skin.js", "skin_charts.js")
"""Scripts that draw any page of a skin and handle its controls."""

_VALUES = 13
"""Numbers of a contact on the page."""


def chosen_frames(recorded: RecordedSkin, wanted: range) -> Chosen:
    """The frames ``wanted``, or every second, third … of them where there is no room."""
    slots = _slots(recorded.found)
    return Chosen.fitting(len(recorded.stress), wanted, frame_bytes(recorded.skin, slots))


def frame_bytes(skin: Skin, slots: int) -> int:
    """Bytes of a frame with room for ``slots`` contacts: stress, its scale, contacts, counts and time."""
    return 2 * skin.sensor.taxels + 4 + slots * 4 * _VALUES + 4 + 8


def render_skin(recorded: RecordedSkin, chosen: Chosen) -> str:
    """The page of a result; depends on its arguments only."""
    shown = slice(chosen.shown.start, chosen.shown.stop, chosen.shown.step)
    label = f"{recorded.name} ({recorded.engine})"
    slots = _slots(recorded.found)
    data = {
        **_described(recorded.skin, slots),
        "start": chosen.shown.start,
        "step": chosen.shown.step,
        "time": None if recorded.time is None else packed(recorded.time[shown], "float64"),
        "results": [
            {
                "label": label,
                "dead": places(recorded.dead),
                **contacts(recorded.found, recorded.found.tracks(), recorded.stress, slots, shown),
            }
        ],
    }
    notes = "".join(f"<li>{escape(line)}</li>" for line in skin_lines(skin_facts(recorded.found)))
    summary = f'<h2>Summary</h2><p class="note">{escape(_sentence(recorded.skin))} {escape(str(chosen))}</p>'
    summary += f'<ul class="note">{notes}</ul>'
    body = _body(label, {"STATE": "", "SUMMARY": summary, "CONTROLS": controls(len(chosen.shown))})
    parts = [body, *scripts(data, "(() =>", ("arrays.js", "given.js", *_DRAWING, "recorded.js"))]
    return document(TITLE, parts, resource("page.css"))


def live_skin_feed(source: str, skin: Skin, estimate: Callable[[Floats], SkinResult]) -> Feed:
    """Frames of ``source`` on their way to a live page of a skin."""
    slots = skin.choices.most
    track = Tracker(2 * min(skin.sensor.pitch_x, skin.sensor.pitch_y))

    def result(stress: Floats) -> dict[str, Any]:
        found = estimate(stress)
        places = np.split(np.stack([found.x, found.y], axis=1), np.cumsum(found.found)[:-1])
        return contacts(found, np.concatenate([track(each) for each in places]), stress, slots)

    return Feed(source, result, frame_bytes(skin, slots))


def render_skin_live(feed: Feed, engine: str, skin: Skin, dead: Bools | None = None) -> str:
    """The live page of ``feed``, which requests frames from its server; ``dead`` as for ``RecordedSkin``."""
    label = f"{feed.source} ({engine})"
    data = {
        **_described(skin, skin.choices.most),
        "seconds": SECONDS,
        "most": feed.most,
        "results": [{"label": label, "dead": places(dead)}],
    }
    body = _body(label, live_parts(_sentence(skin)) | {"CONTROLS": controls()})
    parts = [body, *scripts(data, "(async () =>", ("arrays.js", "feed.js", *_DRAWING, "live.js"))]
    return document(LIVE_TITLE, parts, resource("page.css") + resource("live.css"))


def contacts(
    found: SkinResult, tracks: Ints, stress: Floats, slots: int, shown: slice = slice(None)
) -> dict[str, Any]:
    """The frames ``shown``, each with room for ``slots`` contacts; nan where there is none.

    Lengths are in mm, forces in N, the uncertainty in percent of |F_z|.
    """
    count, seen = len(stress), found.windows
    unsure = seen.uncertainty_share
    columns = {"track": tracks, "x": 1e3 * found.x, "y": 1e3 * found.y}
    columns |= {key: getattr(found, key) for key in ("taxels", "top", "left")}
    columns |= dict(zip(("f_x", "f_y", "f_z"), seen.resultant.T, strict=True))
    columns |= {"f": np.linalg.norm(seen.resultant, axis=1), "mu": seen.mu, "phi": seen.phi_deg}
    columns |= {} if unsure is None else {"uncertainty": 100 * unsure}

    def spread(values: Any, empty: float) -> Any:
        whole = np.full((count, slots), empty)
        whole[found.frame, found.contact] = values
        return whole[shown]

    return {
        "values": {key: packed(spread(values, np.nan), "float32") for key, values in columns.items()},
        "status": packed(spread(seen.status, 0), "int16"),
        "found": packed(found.found[shown], "int16"),
        "dropped": packed(found.dropped[shown], "int16"),
        "stress": scaled(stress[shown].reshape(len(stress[shown]), -1)),
        **({} if seen.threshold is None else {"threshold": 100 * seen.threshold}),
    }


def _slots(found: SkinResult) -> int:
    return max(1, int(found.found.max()))


def _described(skin: Skin, slots: int) -> dict[str, Any]:
    """Data for the scripts of any page of a skin."""
    return {**described(skin.sensor, (*Mark, *Status)), "window": list(skin.shape), "slots": slots}


def _sentence(skin: Skin) -> str:
    rows, columns = skin.shape
    windows = f"a window of {rows}×{columns} taxels for each of up to {skin.choices.most} contacts"
    return f"{describe(skin.sensor)}; {windows}."


def _body(label: str, parts: dict[str, str]) -> str:
    return filled("skin.html", {**parts, "LABEL": escape(label), "LEGEND": legend(), "CURVES": resource("curves.html")})
