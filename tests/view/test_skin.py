"""The page of a skin: what it reads, and that a browser shows the contacts of the arrays, from a file and live."""

import csv
import queue
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import Browser, browser
from tests.cli.test_cli import refusal
from tests.cli.test_skin import SKIN
from tests.view.made import unpacked
from tests.view.test_page import WIDER, fill, go, picture_of, saved
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.model.arrays import Floats
from tfra.model.skin.result import SkinResult, estimate
from tfra.model.tfra import Status, Tfra
from tfra.recordings.facts import status_label
from tfra.runtime.outputs import write_npz
from tfra.view.pack import Chosen
from tfra.view.server import serving
from tfra.view.skin_page import contacts, live_skin_feed, render_skin, render_skin_live
from tfra.view.skinfile import RecordedSkin, read_skin

KINDS = ["track", "x", "y", "f", "mu", "phi", "f_x", "f_y", "f_z", "taxels"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the CONFIG of a skin, its frames, and the result, whose last frame has no contact."""
    folder = tmp_path_factory.mktemp("skin")
    (folder / "skin.toml").write_text(SKIN)
    assert main(["frames", f"{folder / 'skin.toml'}", "--out", f"{folder / 'frames.npz'}"]) == 0
    with np.load(folder / "frames.npz") as frames:
        stress = np.concatenate([frames["frames"], 0 * frames["frames"][:1]])
    write_npz(folder / "with_rest.npz", {"frames": stress}, "frames")
    words = ["estimate", f"{folder / 'skin.toml'}", f"{folder / 'with_rest.npz'}", "--out", f"{folder / 'result.npz'}"]
    assert main(words) == 0
    return folder


@pytest.fixture(scope="module")
def recorded(folder: Path) -> RecordedSkin:
    return read_skin(folder / "result.npz")


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


@pytest.fixture(scope="module")
def shown(tab: Browser, folder: Path, recorded: RecordedSkin) -> Browser:
    (folder / "page.html").write_text(render_skin(recorded, Chosen.all(4)), encoding="utf-8")
    tab.open(folder / "page.html", 1280)
    tab.until("document.body.dataset.ready")
    return tab


def modelled(folder: Path, stress: Floats) -> SkinResult:
    skin = load(folder / "skin.toml").skin
    assert skin
    return estimate(skin, stress, Tfra.of(skin.window))


def test_what_was_written_is_read(folder: Path, recorded: RecordedSkin) -> None:
    expected = modelled(folder, recorded.stress)
    assert recorded.found.found.tolist() == [2, 2, 2, 0]
    for key in ("frame", "contact", "x", "y", "taxels", "top", "left", "found", "dropped"):
        np.testing.assert_allclose(getattr(recorded.found, key), getattr(expected, key), rtol=1e-12, err_msg=key)
    np.testing.assert_array_equal(recorded.found.windows.resultant, expected.windows.resultant)
    np.testing.assert_array_equal(recorded.found.tracks(), expected.tracks())


def test_every_contact_has_its_place_among_the_numbers(recorded: RecordedSkin) -> None:
    found = recorded.found
    data = contacts(found, found.tracks(), recorded.stress, 5, slice(1, 4))
    for key, values in (("x", 1e3 * found.x), ("mu", found.windows.mu), ("f_z", found.windows.resultant[:, 2])):
        numbers = unpacked(data["values"][key]).reshape(3, 5)
        np.testing.assert_allclose(numbers[:2, :2].ravel(), values[2:], rtol=1e-6)
        assert np.isnan(numbers[:2, 2:]).all()
        assert np.isnan(numbers[2]).all()
    codes, scale = (unpacked(data["stress"][key]) for key in ("codes", "scale"))
    stress = recorded.stress[1:]
    np.testing.assert_allclose(
        codes.reshape(3, -1) * scale[:, None], stress.reshape(3, -1), atol=4e-5 * np.abs(stress).max()
    )
    assert unpacked(data["found"]).tolist() == [2, 2, 0]


@pytest.mark.parametrize(
    ("key", "change", "said"),
    [
        ("found", lambda values: 0 * values - 1, "found: counts of contacts are needed, got a negative number"),
        ("found", lambda values: values + 0.5, "found: whole numbers are needed"),
        ("top", lambda values: values * 1e300, "top: whole numbers are needed"),
        ("frame", lambda values: values[::-1], "frame: is not what the numbers of found say"),
        ("x_mm", lambda values: values[:-1], "x_mm: shape (6,) is needed, got (5,)"),
        ("mu", lambda values: np.inf * values, "mu: frame 0 has a value that is not finite"),
        ("status", lambda values: values + (1 << 14), "status: frame 0: is no status"),
        ("config", lambda text: np.array(str(text).replace("[window]", "[outputs]")), "config: outputs: unknown key"),
    ],
)
def test_a_damaged_result_is_refused(
    key: str, change: Any, said: str, folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with np.load(folder / "result.npz") as found:
        held = dict(found)
    file = tmp_path / "damaged.npz"
    write_npz(file, held | {key: change(held[key])}, "estimate")
    told = refusal(capfd, "view", str(file), "--out", str(tmp_path / "page.html"))
    assert told.startswith(f"{file}: {said}"), told
    assert not (tmp_path / "page.html").exists()


def test_it_has_a_page_of_its_own(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    files = [str(folder / "result.npz"), str(folder / "frames.npz")]
    line = "tfra view: RESULT.npz: the result of a skin has a page of its own, got 2"
    assert refusal(capfd, "view", *files, "--out", str(tmp_path / "page.html")) == line
    assert main(["view", files[0], "--out", str(tmp_path / "page.html"), "--every", "2"]) == 0
    assert "2 of 4 frames are shown" in (tmp_path / "page.html").read_text()


def table(tab: Browser, column: str) -> list[str]:
    return list(
        tab.evaluate(f"[...document.querySelectorAll('#contacts td[data-column={column}]')].map(td => td.textContent)")
    )


def numbers(tab: Browser, column: str) -> list[float]:
    return [float(text.replace("−", "-")) for text in table(tab, column)]


def expected(found: SkinResult, frame: int) -> dict[str, Any]:
    """Columns of the table of a frame."""
    of, seen = found.frame == frame, found.windows
    columns = {"track": found.tracks(), "x": 1e3 * found.x, "y": 1e3 * found.y, "mu": seen.mu, "phi": seen.phi_deg}
    columns |= {"f": np.linalg.norm(seen.resultant, axis=1), "taxels": found.taxels}
    columns |= {f"f_{axis}": seen.resultant[:, n] for n, axis in enumerate("xyz")}
    return {name: values[of] for name, values in columns.items()}


@pytest.mark.parametrize("frame", [0, 2])
def test_the_table_is_that_of_the_frame(shown: Browser, recorded: RecordedSkin, frame: int) -> None:
    go(shown, frame)
    known = expected(recorded.found, frame)
    for name in KINDS:
        digits = {"track": 0, "taxels": 0, "x": 1, "y": 1, "phi": 1}.get(name, 3)
        np.testing.assert_allclose(numbers(shown, name), known[name], atol=0.51 * 10.0**-digits, err_msg=name)
    assert shown.evaluate("document.getElementById('counts-now').textContent") == "2 contacts"
    statuses = recorded.found.windows.status[recorded.found.frame == frame]
    for text, status in zip(table(shown, "status"), statuses.tolist(), strict=True):
        assert (status_label(Status.IMPLAUSIBLE) in text) == bool(status & Status.IMPLAUSIBLE)


def test_a_frame_without_contact(shown: Browser) -> None:
    go(shown, 3)
    assert table(shown, "f") == []
    assert shown.evaluate("document.getElementById('counts-now').textContent") == "0 contacts"


def test_lines_are_those_of_the_contacts(shown: Browser, recorded: RecordedSkin) -> None:
    """One of each contact in each panel, from left to right."""
    lines = shown.evaluate("document.getElementById('panels').data.filter(t => t.meta == 'f').map(t => t.y)")
    drawn = [[value for value in line if value is not None] for line in lines if any(line)]
    force, tracks = np.linalg.norm(recorded.found.windows.resultant, axis=1), recorded.found.tracks()
    assert len(drawn) == 2
    for number, line in enumerate(drawn):
        np.testing.assert_allclose(line, force[tracks == number], rtol=1e-6)


def test_a_contact_is_marked(shown: Browser, recorded: RecordedSkin) -> None:
    go(shown, 0)
    place = "const grid = document.getElementById('map').getBoundingClientRect();"
    assert shown.evaluate("document.querySelectorAll('tr.chosen').length") == 0
    for share in np.linspace(0.1, 0.9, 9):
        x, y = shown.evaluate(
            f"(() => {{{place} return [grid.left + {share} * grid.width, grid.top + 0.4 * grid.height]}})()"
        )
        shown.point(x, y)
        if shown.evaluate("document.querySelectorAll('tr.chosen').length"):
            break
    assert shown.evaluate("document.querySelectorAll('tr.chosen').length") == 1


@pytest.mark.parametrize("part", ["arrows", "circles", "windows"])
def test_parts_of_the_map_are_chosen(shown: Browser, part: str) -> None:
    go(shown, 1)
    pictures = [picture_of(shown, "map")]
    for _ in range(2):
        shown.evaluate(f"document.getElementById('{part}').click()")
        pictures.append(picture_of(shown, "map"))
    assert pictures[0] == pictures[2] != pictures[1]


def test_curves_are_saved(shown: Browser, recorded: RecordedSkin) -> None:
    head, *rows = csv.reader(saved(shown, "save-curves", "blob.text()").splitlines())
    columns = dict(zip(head, zip(*rows, strict=True), strict=True))
    assert [int(frame) for frame in columns["frame"]] == recorded.found.frame.tolist()
    np.testing.assert_allclose([float(x) for x in columns["fz_n"]], recorded.found.windows.resultant[:, 2], rtol=1e-6)


def test_it_is_silent_accessible_and_fits(shown: Browser) -> None:
    assert (shown.messages, shown.requests) == ([], [])
    assert faults_at_all_widths(shown) == []
    assert shown.evaluate(WIDER) == []


def test_a_live_page_shows_what_comes(tab: Browser, folder: Path, recorded: RecordedSkin) -> None:
    """More contacts and fewer, numbers that go on from frame to frame, and how it ended."""
    stress, skin = recorded.stress, recorded.skin
    waiting: queue.Queue[Any] = queue.Queue()

    def sent() -> Iterator[Floats]:
        while (frame := waiting.get()) is not None:
            yield frame

    feed = live_skin_feed("here", skin, lambda frames: modelled(folder, frames))
    for work in (feed.run, lambda: feed.read(sent(), lambda fault: None)):
        threading.Thread(target=work, daemon=True).start()
    with serving(render_skin_live(feed, "float", skin), feed, 0) as address:
        tab.open(address)
        for number, frame in enumerate((0, 3, 1, 2)):
            waiting.put(stress[frame])
            tab.until(f"document.getElementById('where').textContent.startsWith('frame {number},')")
            known = expected(recorded.found, frame)
            np.testing.assert_allclose(numbers(tab, "f_z"), known["f_z"], atol=6e-4)
            if frame in (1, 2):  # after a frame without contact they are new ones
                assert numbers(tab, "track") == [2, 3]
        tab.until("document.body.dataset.ready")
        waiting.put(None)
        tab.until("document.getElementById('state').textContent == 'here has ended.'")
        fill(tab, "frame", 0, "input")
        np.testing.assert_allclose(numbers(tab, "f_z"), expected(recorded.found, 0)["f_z"], atol=6e-4)
        assert faults_at_all_widths(tab) == []
        assert tab.messages == []
