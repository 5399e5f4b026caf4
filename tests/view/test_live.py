"""The live page in a browser: it shows what comes, says what became of it, and forgets what is old."""

import queue
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import tfra.view.feed as module
from tests.accessibility import faults, faults_at_all_widths
from tests.browser import Browser, browser
from tests.view.made import project, recording
from tests.view.test_page import WIDER, at, cells, fill, numbers
from tfra.model.arrays import Floats
from tfra.model.tfra import Tfra
from tfra.view.feed import Feed
from tfra.view.page import live_feed, render_live
from tfra.view.server import serving


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Floats]:
    """The design, and frames of contacts alone."""
    of = project(tmp_path_factory.mktemp("live"))
    return of.design, recording(of)[[0, 1, 2, 3, 5, 6, 7, 8]]


@dataclass(frozen=True)
class Sent:
    """A live page whose frames a test sends."""

    feed: Feed
    address: str
    waiting: queue.Queue[Any]

    def send(self, *frames: Floats | str | OSError | None) -> None:
        """Send frames, lines that are none, or an end: None, or an error."""
        for frame in frames:
            self.waiting.put(frame)

    def seen(self, tab: Browser, count: int) -> None:
        """Send nothing until the page has drawn frame ``count - 1``."""
        tab.until(f"document.getElementById('where').textContent.startsWith('frame {count - 1},')")


@contextmanager
def sending(design: Any, estimate: Any = None, swept: bool = True) -> Iterator[Sent]:
    waiting: queue.Queue[Any] = queue.Queue()

    def frames() -> Iterator[Floats | str]:
        while (frame := waiting.get()) is not None:
            if isinstance(frame, OSError):
                raise frame
            yield frame

    feed = live_feed("<b>here</b>", "float", design, estimate or Tfra.of(design), swept)
    for work in (feed.run, lambda: feed.read(frames(), lambda fault: None)):
        threading.Thread(target=work, daemon=True).start()
    with serving(render_live(feed, "float", design), feed, 0) as address:
        yield Sent(feed, address, waiting)


def state(tab: Browser) -> str:
    return str(tab.evaluate("document.getElementById('state').textContent"))


def curve(tab: Browser, name: str) -> list[float]:
    chart = "document.getElementById('panels').data"
    return list(tab.evaluate(f"{chart}.find(trace => trace.meta == '{name}').y.map(Number)"))


def stopped(tab: Browser) -> None:
    """Wait until the page follows no more; its curves are whole then."""
    tab.until("play.textContent == 'Follow'")


def open_page(tab: Browser, sent: Sent) -> None:
    tab.open(sent.address)
    tab.until("document.body.dataset.ready")


def test_it_waits_shows_what_comes_and_says_how_it_ended(tab: Browser, made: tuple[Any, Floats]) -> None:
    design, frames = made
    expected = Tfra.of(design)(frames)
    with sending(design) as sent:
        tab.open(sent.address)
        tab.until("document.getElementById('state').textContent.startsWith('Waiting for the first frame of <b>here')")
        assert tab.evaluate("getComputedStyle(document.querySelector('section')).display") == "none"
        for n in range(3):
            sent.send(frames[n])
            sent.seen(tab, n + 1)
            np.testing.assert_allclose(numbers(tab, "mu"), expected.mu[n], rtol=6e-4)
            np.testing.assert_allclose(numbers(tab, "f_z"), expected.resultant[n, 2], rtol=6e-4)
        tab.until("document.body.dataset.ready")
        assert state(tab) == "Receiving frames from <b>here</b>."
        sent.send("line 4: no", frames[3], None)
        tab.until("document.getElementById('state').textContent == '<b>here</b> has ended.'")
        counts = "4 frames came, 4 were estimated, 4 drawn"
        tab.until(f"document.getElementById('counts').textContent.startsWith('{counts}')")
        fault = tab.evaluate("document.getElementById('fault').textContent")
        assert fault == "Malformed lines: 1. The first: line 4: no."
        stopped(tab)
        np.testing.assert_allclose(curve(tab, "mu"), expected.mu[:4], rtol=1e-6)
        fill(tab, "frame", 1, "input")
        np.testing.assert_allclose(numbers(tab, "mu"), expected.mu[1], rtol=6e-4)
        assert tab.messages == []
        asked = {request.partition("?")[0] for request in tab.requests}
        assert asked == {f"{sent.address}frames", f"{sent.address}drawn"}
        assert sent.feed.totals() == "4 frames came, 4 were estimated, 4 drawn; malformed lines: 1"


@pytest.mark.long
def test_pause_reload_and_what_breaks(tab: Browser, made: tuple[Any, Floats]) -> None:
    design, frames = made
    with sending(design) as sent:
        sent.send(*frames[:2])
        open_page(tab, sent)
        sent.seen(tab, 2)
        tab.evaluate("play.click()")
        sent.send(frames[2])
        tab.evaluate("new Promise(done => setTimeout(done, 100))")
        assert at(tab) == 1
        sent.send(*frames[3:5])
        tab.evaluate("play.click()")
        sent.seen(tab, 5)
        open_page(tab, sent)
        sent.seen(tab, 5)
        np.testing.assert_allclose(curve(tab, "mu"), Tfra.of(design)(frames[:5]).mu, rtol=1e-6)
        sent.send(OSError(5, "Input/output error"))
        tab.until("document.getElementById('state').textContent == '<b>here</b> broke: Input/output error.'")
        assert tab.messages == []


def test_the_server_may_go_when_the_page_has_all(tab: Browser, made: tuple[Any, Floats]) -> None:
    design, frames = made
    with sending(design) as sent:
        sent.send(*frames[:2])
        open_page(tab, sent)
        sent.send(*frames[2:], None)
        sent.feed.wait_for_pages(one=True)
        drawn = sent.feed.counts["drawn"]
    sent.seen(tab, len(frames))
    assert state(tab) == "<b>here</b> has ended."
    stopped(tab)
    assert f", {drawn} drawn here." in tab.evaluate("document.getElementById('counts').textContent")
    fill(tab, "frame", 3, "input")
    np.testing.assert_allclose(numbers(tab, "mu"), Tfra.of(design)(frames).mu[3], rtol=6e-4)
    tab.evaluate("play.click()")
    stopped(tab)
    assert state(tab) == "<b>here</b> has ended."


def test_a_page_that_pauses_does_not_have_all(tab: Browser, made: tuple[Any, Floats]) -> None:
    design, frames = made
    with sending(design) as sent:
        sent.send(frames[0])
        open_page(tab, sent)
        tab.evaluate("play.click()")
        sent.feed.wait_for_pages(one=False)
        sent.send(frames[1], None)
        assert not sent.feed.is_read
        tab.evaluate("play.click()")
        sent.feed.wait_for_pages(one=True)
        sent.seen(tab, 2)


class Taring:
    """A tare that is asked for."""

    told = ""

    def again(self) -> None:
        self.told = "Tare: keep the array at rest."


def test_a_button_asks_for_a_new_tare(tab: Browser, made: tuple[Any, Floats]) -> None:
    design, frames = made
    with sending(design) as sent:
        sent.send(frames[0])
        open_page(tab, sent)
        assert tab.evaluate("document.getElementById('taring').hidden")
        sent.feed.tare = Taring()
        tab.until("!document.getElementById('taring').hidden")
        tab.evaluate("document.getElementById('tare').click()")
        tab.until("document.getElementById('tared').textContent == 'Tare: keep the array at rest.'")
        sent.feed.tare.told = "Tare: the mean of 3 frames."
        tab.until("document.getElementById('tared').textContent == 'Tare: the mean of 3 frames.'")
        sent.send(None)
        tab.until("document.getElementById('tare').hidden")
        assert tab.messages == []


def test_a_command_that_was_ended(tab: Browser, made: tuple[Any, Floats]) -> None:
    design, frames = made
    with sending(design) as sent:
        sent.send(frames[0])
        open_page(tab, sent)
    tab.until("document.getElementById('state').textContent.startsWith('The command tfra live has ended.')")
    assert cells(tab, "status") == ["contact"]


@pytest.mark.long
def test_what_is_old_is_forgotten(tab: Browser, made: tuple[Any, Floats], monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 300 frames 70 are kept, in arrays that are filled many times, and are those that came last."""
    design, frames = made
    monkeypatch.setattr(module, "MOST", 70)
    many = np.array([frames[n % 8] * (1 + n / 300) for n in range(300)])
    with sending(design) as sent:
        sent.send(many[0])
        open_page(tab, sent)
        for n in range(1, 300):
            sent.send(many[n])
            if n % 30 == 0:
                sent.seen(tab, n + 1)
        sent.seen(tab, 300)
        sent.send(None)
        stopped(tab)
        shown = tab.evaluate("document.getElementById('frame').max")
        assert 30 < int(shown) < 70
        result = Tfra.of(design)(many)
        np.testing.assert_allclose(curve(tab, "f_z")[-30:], result.resultant[-30:, 2], rtol=1e-6)
        fill(tab, "frame", int(shown) - 9, "input")
        np.testing.assert_allclose(numbers(tab, "mu"), result.mu[290], rtol=6e-4)
        assert cells(tab, "status") == ["contact"]
        assert tab.messages == []


@pytest.mark.parametrize("width", [1280, 390])
def test_nothing_is_wider_than_the_window(tab: Browser, made: tuple[Any, Floats], width: int) -> None:
    design, frames = made
    with sending(design) as sent:
        sent.send("line 1: " + "9" * 200, *frames, None)
        open_page(tab, sent)
        tab.resize(width)
        tab.until(f"document.querySelector('#panels svg').clientWidth <= {width}")
        assert tab.evaluate("document.documentElement.scrollWidth") == width
        assert tab.evaluate(WIDER) == []
        assert tab.evaluate("document.getElementById('frame').max") == "7"


@pytest.mark.long
def test_accessibility(tab: Browser, made: tuple[Any, Floats]) -> None:
    """Before the first frame, and while frames come."""
    design, frames = made
    with sending(design) as sent:
        tab.open(sent.address)
        assert faults(tab) == []
        sent.feed.tare = Taring()
        sent.feed.tare.again()
        sent.send("line 1: no", *frames)
        tab.until("document.body.dataset.ready")
        assert faults_at_all_widths(tab) == []


@pytest.mark.long
def test_slow_pages_get_no_queue(tab: Browser, made: tuple[Any, Floats]) -> None:
    """While the page does nothing, frames come; then it shows the last of them."""
    design, frames = made
    with sending(design) as sent:
        sent.send(frames[0])
        open_page(tab, sent)
        stop = threading.Event()

        def feed() -> None:
            while not stop.is_set():
                sent.send(frames[1])
                time.sleep(0.005)

        thread = threading.Thread(target=feed)
        thread.start()
        tab.evaluate("(end => { while (performance.now() < end); })(performance.now() + 500)")
        stop.set()
        thread.join()
        came = sent.feed.counts["came"] + sent.waiting.qsize()
        sent.seen(tab, came)
        assert came > 10
        assert tab.messages == []
