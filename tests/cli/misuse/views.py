"""Cases of misuse of pages: files that are no results or don't belong together, and sources that are not there."""

import io
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

from tests.cli.misuse.mistakes import CONFIG, Make, Misuse, nothing, raw
from tfra.cli.main import main as tfra

VIEW = "view r.npz --out page.html {}"
LIVE = "live skin.toml {}"


def result(change: Callable[[dict[str, Any]], dict[str, Any]] = dict, config: str = CONFIG) -> Make:
    """Make ``r.npz``, a good result, and ``wrong.npz``: one by ``config`` with something done to its arrays."""

    def make() -> None:
        Path("other.toml").write_text(config)
        with redirect_stdout(io.StringIO()):
            tfra(["estimate", "skin.toml", "frames.npz", "--out", "r.npz"])
            tfra(["estimate", "other.toml", "frames.npz", "--out", "other.npz"])
        with np.load("other.npz") as held:
            np.savez("wrong.npz", **change(dict(held)))

    return make


def _without(*keys: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    return lambda held: {key: array for key, array in held.items() if key not in keys}


def _first(held: dict[str, Any]) -> dict[str, Any]:
    """The first two frames alone."""
    return {key: array[:2] if array.ndim else array for key, array in held.items()}


PAGES = [
    Misuse("frames as results", nothing, "view frames.npz --out page.html"),
    Misuse("a table as a result", raw("r.npz", b"1,2\n"), VIEW.format("").strip()),
    Misuse("a result of an earlier version", result(_without("stress", "engine", "config")), VIEW.format("wrong.npz")),
    Misuse(
        "results of two sensors",
        result(config=CONFIG.replace("pitch_y_mm = 4", "pitch_y_mm = 3")),
        VIEW.format("wrong.npz"),
    ),
    Misuse("results of two recordings", result(_first), VIEW.format("wrong.npz")),
    Misuse("a result twice", result(), VIEW.format("r.npz")),
    Misuse("frames that a result lacks", result(), VIEW.format("--frames 3:")),
    Misuse(
        "somebody's page as output",
        lambda: (result()(), Path("page.html").write_text("mine"))[0],
        VIEW.format("").strip(),
    ),
    Misuse("no recording to replay", nothing, LIVE.format("wrong.csv")),
    Misuse("nobody at an address", nothing, LIVE.format("tcp://127.0.0.1:1")),
    Misuse("an address without a port", nothing, LIVE.format("tcp://sensor")),
    Misuse("no serial port", nothing, LIVE.format("serial:/dev/none")),
    Misuse("a baud rate that is none", nothing, LIVE.format("serial:/dev/none?baud=x")),
    Misuse("a rate for a stream", nothing, LIVE.format("- --rate 50")),
    Misuse("a port that is none", nothing, LIVE.format("frames.npz --port 99999")),
]
