"""The page in a browser: its numbers are those of the arrays, and its controls do what they say."""

import csv
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import Browser, browser
from tests.view.made import COMPRESSED, CONFIG, NO_CONTACT, write
from tfra.codegen.config.read import load
from tfra.model.tfra import Tfra
from tfra.view.pack import Chosen
from tfra.view.page import render
from tfra.view.resultfile import read_all

WIDER = """[...document.querySelectorAll('body *')].filter(e => !e.closest('.wide, svg'))
  .filter(e => e.getBoundingClientRect().right > innerWidth + 1).map(e => e.tagName + '#' + e.id)"""

KEYS = {"PageUp": 33, "PageDown": 34, "ArrowRight": 39, "ArrowLeft": 37, "End": 35, "Home": 36, " ": 32}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("view")


@pytest.fixture(scope="module")
def arrays(folder: Path) -> dict[str, dict[str, Any]]:
    return write(folder)


@pytest.fixture(scope="module")
def page(folder: Path, arrays: dict[str, dict[str, Any]]) -> str:
    results, known = read_all([folder / f"{name}.npz" for name in arrays])
    return render(results, known, Chosen.of(results, range(24)))


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


def show(tab: Browser, folder: Path, text: str, width: int = 1280) -> None:
    file = folder / "page.html"
    file.write_text(text, encoding="utf-8")
    tab.open(file, width)
    tab.until("document.body.dataset.ready")


@pytest.fixture(scope="module")
def shown(tab: Browser, page: str, folder: Path) -> Browser:
    """The browser with the page of all three files; tests that need another one come behind."""
    show(tab, folder, page)
    return tab


def go(tab: Browser, frame: int) -> None:
    fill(tab, "frame", frame, "input")
    assert at(tab) == frame


def at(tab: Browser) -> int:
    return int(tab.evaluate("document.body.dataset.frame"))


def press(tab: Browser, key: str, shift: bool = False) -> None:
    named = {"key": key, "code": "Space" if key == " " else key, "windowsVirtualKeyCode": KEYS[key]}
    named |= {"modifiers": 8 * shift}
    tab.call("Input.dispatchKeyEvent", type="keyDown", text=" " if key == " " else "", **named)
    tab.call("Input.dispatchKeyEvent", type="keyUp", **named)


def cells(tab: Browser, row: str) -> list[str]:
    return list(tab.evaluate(f"[...document.querySelectorAll('[data-row={row}] td')].map(td => td.textContent)"))


def numbers(tab: Browser, row: str) -> list[float]:
    """A row of a table; nan where nothing is told."""
    return [float(cell.replace("−", "-")) if cell not in ("–", "") else math.nan for cell in cells(tab, row)]


def fill(tab: Browser, name: str, value: object, event: str) -> None:
    field = f"document.getElementById('{name}')"
    tab.evaluate(f"{field}.value = '{value}'")
    tab.evaluate(f"{field}.dispatchEvent(new Event('{event}'))")


def choose(tab: Browser, name: str, value: object) -> None:
    fill(tab, name, value, "change")


def picture_of(tab: Browser, canvas: str) -> str:
    return str(tab.evaluate(f"document.getElementById('{canvas}').toDataURL()"))


# What it shows


def test_it_says_nothing_and_asks_for_nothing(shown: Browser) -> None:
    assert shown.messages == []
    assert shown.requests == []


def test_what_only_learned_results_have_is_hidden(shown: Browser) -> None:
    hidden = ("[data-row=uncertainty]", "#judged", "#shaded", "#alone")
    assert all(shown.evaluate(f"document.querySelector('{place}').hidden") for place in hidden)
    assert shown.evaluate("document.getElementById('panels').layout.shapes") == []
    assert not shown.evaluate("document.getElementById('swept').hidden")


@pytest.mark.parametrize("frame", [0, 7, 23])
def test_numbers_of_a_frame(shown: Browser, arrays: dict[str, dict[str, Any]], frame: int) -> None:
    go(shown, frame)
    held, true = [arrays[name] for name in ("float", "fixed")], arrays["frames"]
    expected = {
        "phi": [*(one["phi_deg"] for one in held), true["phi_ref_deg"]],
        "mu": [*(one["mu"] for one in held), true["mu_ref"]],
        "f": [np.linalg.norm(one, axis=1) for one in (*(one["resultant"] for one in held), true["resultant_ref"])],
        **{
            f"f_{axis}": [one[:, n] for one in (*(one["resultant"] for one in held), true["resultant_ref"])]
            for n, axis in enumerate("xyz")
        },
    }
    for row, values in expected.items():
        np.testing.assert_allclose(numbers(shown, row), [value[frame] for value in values], rtol=6e-4, atol=1e-6)
    for row in ("mu_x", "mu_y"):
        np.testing.assert_allclose(numbers(shown, row)[:2], [one[row][frame] for one in held], rtol=6e-4, atol=1e-6)
    assert cells(shown, "status")[:2] == ["contact", "contact"]


def test_centroids(shown: Browser, arrays: dict[str, dict[str, Any]]) -> None:
    """Their difference has the direction phi, which the model finds in its own way (Eqs. 11, 19-22)."""
    go(shown, 5)
    stress = arrays["float"]["stress"][5].ravel()
    x, y = 4.0 * (np.arange(24) % 6), 3.0 * (np.arange(24) // 6)
    places = {}
    for row, part in (("c", np.minimum(stress, 0)), ("t", np.maximum(stress, 0))):
        places[row] = [float(number.replace("−", "-")) for number in cells(shown, row)[0].split(", ")]
        np.testing.assert_allclose(places[row], [part @ x / part.sum(), part @ y / part.sum()], atol=0.011)
    (cx, cy), (tx, ty) = places["c"], places["t"]
    assert math.degrees(math.atan2(cy - ty, cx - tx)) % 360 == pytest.approx(arrays["float"]["phi_deg"][5], abs=0.3)


def test_frames_that_tell_nothing(shown: Browser) -> None:
    go(shown, NO_CONTACT)
    assert cells(shown, "status")[0] == "no contact"
    assert [cells(shown, row)[0] for row in ("phi", "mu", "f", "c", "t")] == ["–"] * 5
    assert shown.evaluate("document.getElementById('sweep').data.length") == 0
    assert "no sweep" in shown.evaluate("document.getElementById('sweep').textContent")
    go(shown, COMPRESSED)
    assert cells(shown, "status")[0] == "compression only"
    assert cells(shown, "phi")[0] == "–"
    assert numbers(shown, "f_z")[0] < -1


def test_a_taxel_is_chosen_by_pointing_or_by_its_place(shown: Browser, arrays: dict[str, dict[str, Any]]) -> None:
    go(shown, 9)

    def expect(row: int, column: int) -> None:
        held = [arrays[name] for name in ("float", "fixed")]
        peaks = np.abs(held[0]["stress"]).max(), np.abs(held[0]["forces"]).max()
        stress = [one["stress"][9, row, column] / 1e3 for one in held]
        np.testing.assert_allclose(numbers(shown, "taxel-stress"), stress, rtol=6e-4, atol=3e-8 * peaks[0])
        for axis, name in enumerate("xyz"):
            force = [1e3 * one["forces"][9, axis, row, column] for one in held]
            np.testing.assert_allclose(numbers(shown, f"taxel-{name}"), force, rtol=6e-4, atol=0.03 * peaks[1])

    units = shown.evaluate("[...document.querySelectorAll('[data-unit]')].map(place => place.textContent)")
    assert units == ["kPa", "kPa", "kPa", "mN", "mN", "mN"]
    choose(shown, "row", 1)
    choose(shown, "column", 4)
    expect(1, 4)
    shown.evaluate("document.getElementById('map-0').scrollIntoView({block: 'center'})")
    box = shown.evaluate("(box => [box.x, box.y, box.width])(document.getElementById('map-0').getBoundingClientRect())")
    across = (box[2] - 43) / 6  # what is left of the width beside the axis
    shown.point(box[0] + 33 + 2.5 * across, box[1] + 10 + 0.5 * across * 3 / 4)
    assert (shown.evaluate("row.value"), shown.evaluate("column.value")) == ("3", "2")
    expect(3, 2)


def test_charts_have_the_arrays_and_gaps(shown: Browser, arrays: dict[str, dict[str, Any]]) -> None:
    traces = shown.evaluate("document.getElementById('panels').data.map(({name, meta, x, y}) => ({name, meta, x, y}))")
    found = {(trace["name"], trace["meta"]): trace for trace in traces if trace["meta"] != "status"}
    mu = found["float.npz (float)", "mu"]
    expected: list[float | None] = list(arrays["float"]["mu"].astype(np.float32).astype(float))
    expected[NO_CONTACT] = expected[COMPRESSED] = None
    assert mu["y"] == expected
    np.testing.assert_array_equal(mu["x"], 0.01 * np.arange(24))
    assert found["fixed.npz (fixed)", "f_z"]["y"][COMPRESSED] is not None
    assert found["fixed.npz (fixed)", "f_z"]["y"][NO_CONTACT] is None
    np.testing.assert_allclose(found["frames.npz (reference)", "f"]["y"], np.hypot(4, 2))
    error = found["float.npz (float)", "mu_error"]["y"][7]
    assert error == pytest.approx(arrays["float"]["mu"][7] - 0.5, rel=1e-5)
    turning = [found[name, "phi"]["y"] for name in ("float.npz (float)", "frames.npz (reference)")]
    assert arrays["float"]["phi_deg"][0] > arrays["float"]["phi_deg"][1], "it passes through 0"
    phi, true = np.transpose([pair for pair in zip(*turning, strict=True) if None not in pair])
    assert np.abs(np.diff(phi)).max() < 60
    np.testing.assert_allclose(phi - true, 0, atol=40)
    assert len(found) == 6 + 2 * (6 + 1 + 3), "reference values; values, residual and errors of the results"
    marks = [trace["x"] for trace in traces if trace["meta"] == "status"]
    assert marks[0] == [arrays["float"]["time"][NO_CONTACT]] * 2 + [None]


@pytest.mark.parametrize("number", [0, 1])
def test_the_sweep(shown: Browser, arrays: dict[str, dict[str, Any]], number: int) -> None:
    choose(shown, "detail", number)
    go(shown, 8)
    held = arrays[("float", "fixed")[number]]
    (folder,) = {Path(shown.evaluate("location.pathname")).parent}
    design = load(folder / "skin.toml").design
    kept = Tfra.of(design)(held["stress"][8:9], keep_sweep=True).sweep
    assert kept is not None
    chart = shown.evaluate("(({data, layout}) => ({data, layout}))(document.getElementById('sweep'))")
    unit = 1e3
    drawn = [np.array(trace["y"]) * unit for trace in chart["data"][:2]]
    np.testing.assert_allclose(drawn[0], kept.b_z[0], rtol=1e-6)
    np.testing.assert_allclose(drawn[1], kept.b_xy[0], rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(chart["data"][0]["x"], kept.mu[0], atol=1e-6)
    np.testing.assert_allclose(chart["data"][2]["x"], kept.mu[0][kept.plateau[0]], atol=1e-6)
    assert chart["data"][4]["x"] == pytest.approx([kept.mu[0][held["sweep_index"][8]]])
    band = chart["layout"]["shapes"][0]
    assert unit * (band["y1"] - band["y0"]) == pytest.approx(3 * design.adc.lsb)
    choose(shown, "detail", 0)


# What it does


def test_keys(shown: Browser) -> None:
    go(shown, 5)
    shown.evaluate("document.activeElement.blur()")
    for key, frame in (("ArrowRight", 6), ("ArrowRight", 7), ("ArrowLeft", 6)):
        press(shown, key)
        assert at(shown) == frame
    press(shown, "End")  # scrolls
    assert at(shown) == 6
    shown.evaluate("document.getElementById('frame').focus()")
    for key, frame in (("End", 23), ("ArrowRight", 23), ("Home", 0), ("ArrowLeft", 0), ("ArrowRight", 1)):
        press(shown, key)
        assert at(shown) == frame
    assert shown.evaluate("document.getElementById('frame').getAttribute('aria-valuetext')") == "frame 1, 0.01 s"
    shown.evaluate("document.getElementById('row').focus()")
    press(shown, "ArrowRight")
    assert at(shown) == 1
    shown.evaluate("document.activeElement.blur()")
    press(shown, "PageUp")
    assert at(shown) == 23, "by 100"
    press(shown, "ArrowLeft", shift=True)
    assert at(shown) == 0


def test_the_address_names_the_frame(shown: Browser) -> None:
    go(shown, 12)
    shown.until("location.hash == '#frame=12'")
    shown.evaluate("location.hash = '#frame=17'")
    shown.until("document.body.dataset.frame == 17")


def saved(tab: Browser, button: str, read: str) -> Any:
    """What ``read`` makes of the ``blob`` that a button saves."""
    return tab.evaluate(
        "new Promise(done => { const make = URL.createObjectURL;"
        f"URL.createObjectURL = blob => {{ URL.createObjectURL = make; ({read}).then(done); return make(blob); }};"
        f"document.getElementById('{button}').click(); }})"
    )


def test_curves_are_saved(shown: Browser, arrays: dict[str, dict[str, Any]]) -> None:
    head, *rows = csv.reader(saved(shown, "save-curves", "blob.text()").splitlines())
    assert head[:3] == ["frame", "time_s", "phi_deg float.npz (float)"]
    columns = dict(zip(head, zip(*rows, strict=True), strict=True))
    assert columns["time_s"][7] == "0.07"
    mu = columns["mu float.npz (float)"]
    assert mu[NO_CONTACT] == ""
    assert float(mu[7]) == pytest.approx(arrays["float"]["mu"][7], rel=1e-6)
    error = float(columns["f_error_n fixed.npz (fixed)"][7])
    force, true = arrays["fixed"]["resultant"][7], arrays["frames"]["resultant_ref"][7]
    assert error == pytest.approx(np.linalg.norm(force - true), rel=1e-4)


def test_maps_are_saved(shown: Browser) -> None:
    size = saved(shown, "save-map", "createImageBitmap(blob).then(image => [blob.type, image.width, image.height])")
    whole = shown.evaluate("document.querySelector('.maps').clientWidth")
    maps = shown.evaluate("[0, 1].map(n => document.getElementById(`map-${n}`).clientHeight)")
    assert size[:2] == ["image/png", whole + 16]
    assert size[2] > sum(maps)


def test_play_goes_on_to_the_last_frame_and_begins_again(shown: Browser) -> None:
    choose(shown, "speed", 5)  # seconds are left to stop it
    go(shown, 2)
    shown.evaluate("document.activeElement.blur()")
    press(shown, " ")
    assert shown.evaluate("play.textContent") == "Pause"
    shown.until("Number(document.body.dataset.frame) > 2")
    press(shown, " ")
    assert shown.evaluate("play.textContent") == "Play"
    stopped = at(shown)
    assert shown.evaluate("new Promise(done => setTimeout(() => done(document.body.dataset.frame), 100))") == str(
        stopped
    )
    choose(shown, "speed", 1000)
    shown.evaluate("play.click()")
    shown.until("document.body.dataset.frame == 23 && play.textContent == 'Play'")
    choose(shown, "speed", 1)
    shown.evaluate("play.click()")
    assert shown.until("document.body.dataset.frame == 0")
    shown.evaluate("play.click()")


def test_the_cursor_and_a_click_on_a_chart(shown: Browser) -> None:
    """The cursor is over the place at which the chart itself has a value's mark."""
    marks = "document.querySelectorAll('#panels .subplot.xy .point')"
    for frame in (12, 20):
        go(shown, frame)
        middle = "(box => box.x + box.width / 2)"
        place = shown.evaluate(f"{middle}({marks}[{frame - 2}].getBoundingClientRect())")
        assert shown.evaluate(f"{middle}(cursor.getBoundingClientRect())") == pytest.approx(place, abs=1.5)
    shown.evaluate("document.getElementById('panels').emit('plotly_click', {points: [{x: 0.07}]})")
    assert at(shown) == 7


@pytest.mark.parametrize(
    ("field", "value", "canvas"),
    [
        *((toggle, None, "map-1") for toggle in ("resultant", "arrows", "circles", "centroids")),
        ("scale", "linear", "map-0"),
        ("of", "left", "map-0"),
        ("height", "force", "surface"),
    ],
)
def test_controls_change_what_is_drawn(shown: Browser, field: str, value: object, canvas: str) -> None:
    go(shown, 14)
    before = picture_of(shown, canvas)
    chosen = shown.evaluate(f"document.getElementById('{field}').value")
    for new, same in ((value, False), (chosen, True)):
        if value is None:
            shown.evaluate(f"document.getElementById('{field}').click()")
        else:
            choose(shown, field, new)
        assert (picture_of(shown, canvas) == before) == same


def test_the_surface_turns(shown: Browser) -> None:
    before = picture_of(shown, "surface")
    fill(shown, "turn", 80, "input")
    assert picture_of(shown, "surface") != before


@pytest.mark.parametrize("width", [1280, 390])
def test_nothing_is_wider_than_the_window(shown: Browser, width: int) -> None:
    shown.resize(width)
    shown.until(f"document.querySelector('#panels svg').clientWidth <= {width}")
    assert shown.evaluate("document.documentElement.scrollWidth") == width
    assert shown.evaluate(WIDER) == []
    assert shown.messages == []
    assert shown.requests == []


def test_the_map_is_in_the_first_screen_of_a_phone(shown: Browser) -> None:
    shown.resize(390, 844)
    shown.evaluate("scrollTo(0, 0)")
    assert shown.evaluate("document.getElementById('map-0').getBoundingClientRect().bottom") < 844


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_accessibility(shown: Browser, scheme: str) -> None:
    """In colours that follow those of the system, charts, too."""
    shown.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    paper = {"dark": "#16191d", "light": "#fff"}[scheme]
    shown.until(f"document.getElementById('panels').layout.paper_bgcolor == '{paper}'")
    assert faults_at_all_widths(shown) == []


# Other pages


def test_dead_taxels_are_crossed_and_a_link_opens_its_frame(
    tab: Browser, folder: Path, arrays: dict[str, dict[str, Any]]
) -> None:
    dead = np.zeros((4, 6), dtype=np.uint8)
    dead[1, 2] = 1
    np.savez(folder / "dead.npz", **arrays["float"] | {"dead": dead})
    results, _ = read_all([folder / "dead.npz"])
    (folder / "page.html").write_text(render(results, [], Chosen.of(results, range(24))), encoding="utf-8")
    tab.open(f"{(folder / 'page.html').as_uri()}#frame=5")
    tab.until("document.body.dataset.ready")
    assert at(tab) == 5
    assert "dead" in tab.evaluate("document.getElementById('key').textContent")
    for name in ("resultant", "arrows", "centroids"):
        tab.evaluate(f"document.getElementById('{name}').click()")
    across = tab.evaluate("(document.getElementById('map-0').clientWidth - 43) / 6")
    places = [(round(33 + (2.5 + n) * across), round(8 + 2.5 * across * 3 / 4)) for n in (0, 1)]
    pen = "document.getElementById('map-0').getContext('2d')"
    middles = [sum(tab.evaluate(f"[...{pen}.getImageData({x}, {y}, 1, 1).data]")[:3]) for x, y in places]
    assert middles[0] < 150 < middles[1]


def test_a_part_of_the_frames(tab: Browser, folder: Path, arrays: dict[str, dict[str, Any]]) -> None:
    results, _ = read_all([folder / "fixed.npz"])
    show(tab, folder, render(results, [], Chosen(range(3, 24, 4), 24, 2, False)))
    go(tab, 3)
    assert tab.evaluate("document.getElementById('where').textContent") == "frame 15"
    assert numbers(tab, "mu") == pytest.approx([arrays["fixed"]["mu"][15]], rel=6e-4)
    assert tab.evaluate("document.getElementById('sweep-of').textContent") == "The sweep shown is that of frame 11."
    assert tab.evaluate("document.getElementById('panels').data[1].x") == [3, 7, 11, 15, 19, 23]
    assert "6 of 24 frames are shown: every 4th frame from 3 to 23; every 2nd of them" in tab.evaluate(
        "document.body.textContent"
    )
    assert tab.messages == []


def test_a_search_without_a_sweep_has_no_winner(tab: Browser, folder: Path, arrays: dict[str, dict[str, Any]]) -> None:
    """The search in mu_x and mu_y gives -1 as its index."""
    np.savez(folder / "two.npz", **arrays["float"] | {"sweep_index": np.full(24, -1)})
    results, _ = read_all([folder / "two.npz"])
    show(tab, folder, render(results, [], Chosen.of(results, range(24))))
    go(tab, 8)
    names = tab.evaluate("document.getElementById('sweep').data.map(trace => [trace.name, trace.x.length])")
    assert [count for name, count in names if name == "winner"] == [0, 0]
    assert tab.messages == []


@pytest.mark.parametrize("count", [1, 2])
def test_few_frames(tab: Browser, folder: Path, arrays: dict[str, dict[str, Any]], count: int) -> None:
    results, _ = read_all([folder / "float.npz"])
    show(tab, folder, render(results, [], Chosen(range(count), 24, 1, False)))
    tab.evaluate("play.click()")
    tab.until("play.textContent == 'Play'")
    assert at(tab) == count - 1
    assert tab.messages == []


def test_nothing_but_zeros_and_a_name_that_is_a_tag(
    tab: Browser, folder: Path, arrays: dict[str, dict[str, Any]]
) -> None:
    name = "<img src=x onerror=alert(1)>$&\"'.npz"
    zero = np.zeros((3, 4, 6))
    found = Tfra.of(load(folder / "skin.toml").design)(zero)
    held = {key: getattr(found, key) for key in arrays["float"] if hasattr(found, key)}
    with open(folder / name, "wb") as stream:
        np.savez(stream, stress=zero, engine=np.array("</script>"), config=np.array(CONFIG), **held)
    results, _ = read_all([folder / name])
    show(tab, folder, render(results, [], Chosen.of(results, range(3))))
    assert name in tab.evaluate("document.querySelector('figcaption').textContent")
    assert "3 of 3 frames no contact" in tab.evaluate("document.getElementById('notes').textContent")
    assert tab.messages == []
    assert tab.requests == []


def test_equal_files_give_equal_bytes(page: str, folder: Path, arrays: dict[str, dict[str, Any]]) -> None:
    command = [sys.executable, "-m", "tfra.cli", "view", *(f"{name}.npz" for name in arrays), "--out", "again.html"]
    subprocess.run(command, check=True, cwd=folder, capture_output=True, env=os.environ | {"PYTHONHASHSEED": "7"})
    assert (folder / "again.html").read_text(encoding="utf-8").startswith(page)


def test_a_corrupted_number_is_noticed(shown: Browser, folder: Path, arrays: dict[str, dict[str, Any]]) -> None:
    wrong = {key: np.copy(array) for key, array in arrays["float"].items()}
    wrong["mu"][7] *= 1.01
    np.savez(folder / "wrong.npz", **wrong)
    results, known = read_all([folder / "wrong.npz", folder / "fixed.npz", folder / "frames.npz"])
    show(shown, folder, render(results, known, Chosen.of(results, range(24))))
    with pytest.raises(AssertionError, match="Not equal to tolerance"):
        test_numbers_of_a_frame(shown, arrays, 7)
