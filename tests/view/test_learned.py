"""Results of the learned estimator on a page: no sweep, and a residual beside the other figures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser import Browser, browser
from tests.marks import long
from tests.view.made import CONFIG, NO_CONTACT, project, recording, write
from tests.view.test_live import curve, open_page, sending
from tests.view.test_page import WIDER, cells, choose, go, numbers, show
from tfra.model.arrays import Floats
from tfra.model.choices import Search
from tfra.model.tfra import Result, Tfra
from tfra.view.chosen import MOST_SWEEP_BYTES, Chosen
from tfra.view.feed import Feed
from tfra.view.pack import result
from tfra.view.page import render
from tfra.view.resultfile import read_all

ESTIMATOR = '[estimator]\nkind = "learned"\nweights = "nowhere.npz"\n'

RESIDUAL = np.linspace(0.001, 0.9, 24)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of both estimators, ``learned.npz`` and ``float.npz``, of the same frames."""
    place = tmp_path_factory.mktemp("learned")
    held = write(place)["float"]
    figures = {"uncertainty": RESIDUAL, "residual": RESIDUAL}
    more = figures | {"sweep_index": np.full(24, -1), "config": np.array(CONFIG + ESTIMATOR)}
    np.savez(place / "learned.npz", **held | more)
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


def test_it_alone(tab: Browser, folder: Path) -> None:
    show_all(tab, folder, "learned")
    go(tab, 7)
    assert numbers(tab, "residual") == pytest.approx([100 * RESIDUAL[7]], rel=6e-4)
    assert is_shown(tab, "[data-row=residual]")
    assert not is_shown(tab, "#swept")
    drawn = panels(tab)["learned.npz (float)", "residual"]
    assert drawn[NO_CONTACT] is None
    np.testing.assert_allclose(drawn[NO_CONTACT + 1 :], 100 * RESIDUAL[NO_CONTACT + 1 :], rtol=1e-6)
    go(tab, NO_CONTACT)
    assert cells(tab, "residual") == ["–"]
    assert tab.messages == []


@pytest.mark.parametrize("width", [390, *long(1280)])
def test_beside_a_result_of_tfra(tab: Browser, folder: Path, width: int) -> None:
    show_all(tab, folder, "learned", "float", width=width)
    go(tab, 7)
    assert numbers(tab, "residual") == pytest.approx([100 * RESIDUAL[7], np.nan], rel=6e-4, nan_ok=True)
    assert [name for name, meta in panels(tab) if meta == "residual"] == ["learned.npz (float)"]
    assert tab.evaluate("document.getElementById('sweep').data.length") == 0
    assert "no sweep: the estimator" in tab.evaluate("document.getElementById('sweep').textContent")
    choose(tab, "detail", 1)
    assert tab.evaluate("document.getElementById('sweep').data.length") == 6
    assert tab.evaluate(WIDER) == []
    assert tab.messages == []


def test_live(tab: Browser, tmp_path: Path) -> None:
    of = project(tmp_path)
    model, frames = Tfra.of(of.design), recording(of)

    def estimate(stress: Floats) -> Result:
        count = len(stress)
        return replace(model(stress), sweep_index=np.full(count, -1), residual=np.full(count, 0.125))

    fine = replace(of.design, search=Search(4096))
    most = {swept: Feed("here", "float", fine, estimate, swept).most for swept in (False, True)}
    assert most[False] > most[True]
    with sending(of.design, estimate, swept=False) as sent:
        sent.send(frames[0])
        open_page(tab, sent)
        for n in (1, 2):
            sent.send(frames[n])
            sent.seen(tab, n + 1)
        assert numbers(tab, "residual") == [12.5]
        sent.send(None)
        tab.until("document.getElementById('state').textContent.endsWith('has ended.')")
        assert curve(tab, "residual") == [12.5] * 3
        assert not is_shown(tab, "#swept")
        assert tab.messages == []


def test_a_residual_that_is_no_number_is_refused(folder: Path) -> None:
    held: dict[str, Any] = dict(np.load(folder / "learned.npz"))
    held["residual"] = np.where(np.arange(24) == 5, np.nan, RESIDUAL)
    np.savez(folder / "wrong.npz", **held)
    with pytest.raises(ValueError, match=r"wrong.npz: residual: frame 5 has a value that is not finite"):
        read_all([folder / "wrong.npz"])
