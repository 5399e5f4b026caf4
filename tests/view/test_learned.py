"""Results of the learned estimator on a page: no sweep, a residual, an uncertainty with its threshold, and results of
a core without forces at the taxels."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.accessibility import faults
from tests.browser import Browser, browser
from tests.marks import long
from tests.view.made import CONFIG, KEYS, NO_CONTACT, project, write
from tests.view.test_live import curve, open_page, sending, stopped
from tests.view.test_page import WIDER, cells, choose, go, numbers, picture_of, show
from tfra.model.arrays import Floats
from tfra.model.choices import Search
from tfra.model.tfra import Result, Status, Tfra
from tfra.view.pack import MOST_SWEEP_BYTES, Chosen, result
from tfra.view.page import live_feed, render
from tfra.view.resultfile import read_all

ESTIMATOR = '[estimator]\nkind = "learned"\nweights = "nowhere.npz"\n'

RESIDUAL = np.linspace(0.001, 0.9, 24)

THRESHOLD = 0.25

UNSURE = np.tile([0.1, 0.4, 0.2, 0.3, 0.3, 0.1], 4)
"""Uncertainty over |F_z| of the frames."""

PULLS, STILL = 6, 8
"""Frames whose resultant pulls, and whose F_z is zero."""

BANDS = [(0.5, 1.5), (2.5, 3.5), (5.5, 10.5), (12.5, 13.5), (14.5, 16.5), (18.5, 19.5), (20.5, 22.5)]
"""Runs of implausible frames, from half a frame before to half a frame after."""

ALONE = "alone.npz (fixed): no forces at the taxels: this core gives the resultant alone."


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of both estimators, ``learned.npz`` and ``float.npz``, and of a core without forces at the taxels,
    ``alone.npz``, all of the same frames."""
    place = tmp_path_factory.mktemp("learned")
    held = write(place)["float"]
    resultant = held["resultant"].copy()
    resultant[PULLS, 2], resultant[STILL, 2] = 0.5, 0.0
    unsure = (UNSURE > THRESHOLD) | (resultant[:, 2] >= 0)
    implausible = np.where(unsure & (np.arange(24) != NO_CONTACT), Status.IMPLAUSIBLE, 0)
    made = held | {
        "resultant": resultant,
        "uncertainty": UNSURE * np.abs(resultant[:, 2]),
        "threshold": np.array(THRESHOLD),
        "sweep_index": np.full(24, -1),
        "status": np.where(held["status"] == Status.NO_CONTACT, Status.NO_CONTACT, implausible),
        "config": np.array(CONFIG + ESTIMATOR),
    }
    np.savez(place / "learned.npz", **made | {"residual": RESIDUAL})
    short = {"forces": np.full((24, 3, 4, 6), np.nan), "engine": np.array("fixed")}
    np.savez(place / "alone.npz", **made | short)
    return place


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


def show_all(tab: Browser, folder: Path, *names: str, width: int = 1280) -> None:
    results, _ = read_all([folder / f"{name}.npz" for name in names])
    show(tab, folder, render(results, [], Chosen.of(results, range(24))), width)


def is_shown(tab: Browser, place: str) -> bool:
    return bool(tab.evaluate(f"document.querySelector('{place}').getClientRects().length"))


def panels(tab: Browser) -> dict[tuple[str, str], list[float | None]]:
    traces = tab.evaluate("document.getElementById('panels').data.map(({name, meta, y}) => [name, meta, y])")
    return {(name, meta): y for name, meta, y in traces}


def test_a_result_without_a_sweep(folder: Path) -> None:
    (learned, swept), _ = read_all([folder / "learned.npz", folder / "float.npz"])
    assert (learned.swept, swept.swept) == (False, True)
    assert (learned.found.residual is None, swept.found.residual is None) == (False, True)
    chosen = Chosen(range(24), 24, 1, False)
    assert result(swept, chosen).keys() - result(learned, chosen).keys() == {"sweep"}
    many = replace(learned, stress=np.broadcast_to(0.0, (MOST_SWEEP_BYTES // 800, 4, 6)))
    assert (Chosen.of([many], range(len(many.stress))).sweeps, Chosen.of([many, swept], range(24)).sweeps) == (1, 1)
    assert Chosen.of([replace(many, swept=True)], range(len(many.stress))).sweeps == 2


@pytest.mark.parametrize("width", [390, *long(1280)])
def test_beside_a_result_of_tfra(tab: Browser, folder: Path, width: int) -> None:
    show_all(tab, folder, "learned", "float", width=width)
    go(tab, 7)
    assert numbers(tab, "residual")[0] == pytest.approx(100 * RESIDUAL[7], rel=6e-4)
    assert [meta for _, meta in panels(tab)].count("residual") == 2
    assert tab.evaluate("document.getElementById('sweep').data.length") == 0
    assert "no sweep: the estimator" in tab.evaluate("document.getElementById('sweep').textContent")
    choose(tab, "detail", 1)
    assert tab.evaluate("document.getElementById('sweep').data.length") == 6
    assert tab.evaluate(WIDER) == []
    assert tab.messages == []


def flagged(tab: Browser) -> list[bool]:
    """Which maps are marked as implausible."""
    return list(tab.evaluate("[...document.querySelectorAll('figure')].map(map => map.classList.contains('flagged'))"))


def runs(path: str) -> list[tuple[float, float]]:
    """First and last place of each part of a band."""
    return [(float(a), float(b)) for a, b in re.findall(r"M([-.\de]+),0V1H([-.\de]+)V0Z", path)]


def test_it_alone(tab: Browser, folder: Path) -> None:
    """Its residual, its uncertainty and the threshold of that."""
    show_all(tab, folder, "learned")
    assert is_shown(tab, "[data-row=residual]")
    assert not is_shown(tab, "#swept")
    drawn = panels(tab)["learned.npz (float)", "residual"]
    assert drawn[NO_CONTACT] is None
    np.testing.assert_allclose(drawn[NO_CONTACT + 1 :], 100 * RESIDUAL[NO_CONTACT + 1 :], rtol=1e-6)
    drawn = panels(tab)["learned.npz (float)", "uncertainty"]
    expected = np.where(np.isin(np.arange(24), (NO_CONTACT, STILL)), np.nan, 100 * UNSURE)
    np.testing.assert_allclose(np.array(drawn, dtype=float), expected, rtol=1e-6)
    told = {0: "10 ≤ 25", 1: "40 > 25", NO_CONTACT: "–", PULLS: "F does not press", STILL: "F does not press"}
    for frame, words in told.items():
        go(tab, frame)
        assert cells(tab, "uncertainty") == [words]
        residual = np.nan if frame == NO_CONTACT else 100 * RESIDUAL[frame]
        assert numbers(tab, "residual") == pytest.approx([residual], rel=6e-4, nan_ok=True)
        unsure = frame in (1, PULLS, STILL)
        assert cells(tab, "status") == [{NO_CONTACT: "no contact"}.get(frame, "implausible" if unsure else "contact")]
        assert flagged(tab) == [unsure]
        assert tab.evaluate("document.getElementById('map-0').ariaLabel").count("implausible") == unsure
    band, line = tab.evaluate("document.getElementById('panels').layout.shapes")
    assert (line["y0"], line["y1"]) == (25, 25)
    np.testing.assert_allclose(runs(band["path"]), 0.01 * np.array(BANDS), atol=1e-9)
    assert "error bar" in tab.evaluate("document.getElementById('judged').textContent")
    summary = tab.evaluate("document.getElementById('summary').textContent")
    assert "uncertainty, median25 % of |Fz|implausible over25 % of |Fz|" in summary
    go(tab, 1)
    assert faults(tab) == []
    assert tab.messages == []


@pytest.mark.parametrize("width", [390, *long(1280)])
def test_the_resultant_alone(tab: Browser, folder: Path, width: int) -> None:
    show_all(tab, folder, "alone", width=width)
    (alone,), _ = read_all([folder / "alone.npz"])
    go(tab, 7)
    for row, value in zip(("f_x", "f_y", "f_z"), alone.found.resultant[7], strict=True):
        assert numbers(tab, row) == pytest.approx([value], rel=6e-4)
    assert tab.evaluate("document.getElementById('alone').textContent") == ALONE
    gone = ("#arrows", "#circles", "[data-row=taxel-x]", "[data-row=taxel-y]", "[data-row=taxel-z]", "#swept")
    assert [place for place in gone if is_shown(tab, place)] == []
    assert tab.evaluate("document.getElementById('height').options[1].disabled")
    assert "N, longest" not in tab.evaluate("document.getElementById('key').textContent")
    before = picture_of(tab, "map-0")
    tab.evaluate("document.getElementById('resultant').click()")
    assert picture_of(tab, "map-0") != before
    text = tab.evaluate("document.body.innerText")
    assert [word for word in ("NaN", "undefined", "Infinity") if word in text] == []
    assert tab.evaluate(WIDER) == []
    assert faults(tab) == []
    assert tab.messages == []


def test_the_resultant_alone_beside_forces_at_the_taxels(tab: Browser, folder: Path) -> None:
    show_all(tab, folder, "learned", "alone", "float")
    go(tab, 7)
    assert numbers(tab, "f_z")[0] == numbers(tab, "f_z")[1]
    assert np.isnan(numbers(tab, "taxel-z")).tolist() == [False, True, False]
    assert tab.evaluate("document.getElementById('alone').textContent") == ALONE
    assert is_shown(tab, "#arrows")
    choose(tab, "height", "force")
    choose(tab, "detail", 1)
    assert tab.evaluate("document.getElementById('height').value") == "stress"
    choose(tab, "detail", 2)
    assert not tab.evaluate("document.getElementById('height').options[1].disabled")
    go(tab, 1)
    assert flagged(tab) == [True, True, False]
    assert "NaN" not in tab.evaluate("document.body.innerText")
    assert tab.messages == []


@pytest.mark.long
def test_live_of_the_resultant_alone(tab: Browser, folder: Path, tmp_path: Path) -> None:
    of = project(tmp_path)
    (alone,), _ = read_all([folder / "alone.npz"])
    came = iter(range(24))
    fine = replace(of.design, search=Search(4096))
    most = {swept: live_feed("here", "float", fine, Tfra.of(fine), swept).most for swept in (False, True)}
    assert most[False] > most[True]

    def estimate(stress: Floats) -> Result:
        now = [next(came) for _ in stress]
        arrays = {key: getattr(alone.found, key)[now] for key in (*KEYS, "uncertainty")}
        return Result(**arrays, threshold=THRESHOLD, residual=np.full(len(now), 0.125))

    with sending(of.design, estimate, swept=False) as sent:
        for n in range(3):
            sent.send(alone.stress[n])
            if n == 0:
                open_page(tab, sent)
            sent.seen(tab, n + 1)
        assert cells(tab, "uncertainty") == ["20 ≤ 25"]
        assert numbers(tab, "residual") == [12.5]
        assert "no forces at the taxels" in tab.evaluate("document.getElementById('alone').textContent")
        assert not is_shown(tab, "#arrows")
        assert not is_shown(tab, "#swept")
        sent.send(None)
        tab.until("document.getElementById('state').textContent.endsWith('has ended.')")
        stopped(tab)
        assert curve(tab, "uncertainty") == pytest.approx([10, 40, 20])
        assert curve(tab, "residual") == [12.5] * 3
        go(tab, 1)
        assert flagged(tab) == [True]
        assert "NaN" not in tab.evaluate("document.body.innerText")
        assert tab.messages == []
