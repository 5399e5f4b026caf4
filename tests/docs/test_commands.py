"""Every command in the README and in docs/ works.

Blocks are executed line by line.  Of commands that take long, and of those that sentences name, arguments are checked.
"""

import importlib.util
import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest
import typer

from tests.marks import long
from tests.recordings.test_log import ARRAY, StoragePlugin, array, bag
from tfra.cli.main import app, main
from tfra.codegen.config.read import load

ROOT = Path(__file__).parents[2]
PAGES = ["README.md", *sorted(str(page.relative_to(ROOT)) for page in (ROOT / "docs").rglob("*.md"))]

COMMAND = re.compile(r"(?:\$ )?(?:\.venv/bin/)?((?:tfra|make|python -m|pip install)\s.*)")

PLACEHOLDERS = {
    "CONFIG": "examples/hertz_40x20.toml",
    "FRAMES": "frames.npz",
    "STUDY": "examples/study_quick.toml",
    "OUT": "out",
}
"""What a page leaves to the reader, and a value of it."""

LONG = {"calibrate", "synth", "study", "paper", "live", "train", "verify"}
"""Commands of which only the arguments are checked here, since they take long or never end: other tests run them."""

TASTE = re.compile(r"COMMAND|…|\.\.\.|: ")
"""In what is no command: part of one, or a message."""


FENCE = re.compile(r"^ *(?:<!-- (?P<mark>[a-z ]+) -->\n *)?```\w*\n(?P<lines>.*?)^ *```", re.M | re.S)

WHOLE = "run"
"""Mark of a block that tests/docs/test_replayed.py runs as a whole."""


def commands(page: str) -> tuple[list[str], list[str]]:
    """The commands of a page: those in blocks, which are to be copied, and those that sentences name."""
    text = (ROOT / page).read_text()
    blocks = [line for found in FENCE.finditer(text) if found["mark"] != WHOLE for line in _lines(found)]
    named = re.findall(r"`([^`\n]+)`", FENCE.sub("", text))
    return _commands(blocks), _commands(named)


def marked(mark: str) -> list[tuple[str, list[str]]]:
    """The page and the lines of every block with this mark."""
    found = ((page, block) for page in PAGES for block in FENCE.finditer((ROOT / page).read_text()))
    return [(page, _lines(block)) for page, block in found if block["mark"] == mark]


def _lines(block: re.Match[str]) -> list[str]:
    return [line.strip() for line in block["lines"].splitlines()]


def _commands(lines: list[str]) -> list[str]:
    found = (COMMAND.fullmatch(line.strip()) for line in lines)
    return list(dict.fromkeys(match[1] for match in found if match and not TASTE.search(match[1])))


EVERY = [(page, line) for page in PAGES for part in commands(page) for line in part]


def of(program: str) -> list[tuple[str, str]]:
    return [(page, line) for page, line in EVERY if line.startswith(program)]


@pytest.mark.parametrize(("page", "line"), of("make "))
def test_make(page: str, line: str) -> None:
    targets = shlex.split(line, comments=True)[1:]
    done = subprocess.run(["make", "-n", *targets], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("page", "line"), of("python -m "))
def test_modules(page: str, line: str) -> None:
    module = shlex.split(line, comments=True)[2]
    found = importlib.util.find_spec(module)
    assert found is not None
    assert found.origin is not None
    assert '__name__ == "__main__"' in Path(found.origin).read_text()


@pytest.mark.parametrize(("page", "line"), of("pip install "))
def test_extras(page: str, line: str) -> None:
    (wanted,) = re.findall(r"tfra\[(\w+)\]", line)
    assert wanted in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


def command(name: str) -> typer.core.TyperCommand:
    """The command of that name; raises ``KeyError`` if there is none."""
    group = typer.main.get_command(app)
    assert isinstance(group, typer.core.TyperGroup)
    found = group.commands[name]
    assert isinstance(found, typer.core.TyperCommand)
    return found


def parsed(words: list[str]) -> None:
    """Raise an exception for arguments that the command line does not take."""
    command(words[0]).make_context(words[0], words[1:])


def test_wrong_arguments_are_noticed() -> None:
    parsed(["synth", "examples/fast.toml", "--target", "ecp5-85", "--out", "synth"])
    for words in (["synth", "--targets", "ecp5-85"], ["synth", "a.toml", "--seeds", "0", "--out", "x"]):
        with pytest.raises(typer.TyperException):
            parsed(words)
    with pytest.raises(KeyError):
        parsed(["synthesise"])


@pytest.mark.parametrize(("page", "line"), [(page, line) for page in PAGES for line in commands(page)[1]])
def test_what_sentences_name(page: str, line: str) -> None:
    """A command that is there, and its options."""
    words = shlex.split(line)
    if words[0] != "tfra" or words[1].startswith("-"):
        return
    known = {name for option in command(words[1]).params for name in (*option.opts, *option.secondary_opts)}
    assert {word.partition("=")[0] for word in words[2:] if word.startswith("-")} <= known | {"--help"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder as a reader has it: the examples, a sensor of one's own, and recordings of it in several forms."""
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(ROOT / "examples")
    text = (ROOT / "examples" / "hertz_40x20.toml").read_text()
    Path("sensor.toml").write_text(text)
    Path("bits/designs").mkdir(parents=True)
    Path("bits/designs/least_coefficient_kbit.toml").write_text(text)
    assert main(["frames", "sensor.toml", "--out", "frames.npz"]) == 0
    frames = np.load("frames.npz")["frames"]
    rest = np.zeros((60, *frames.shape[1:]))
    recording = np.concatenate([rest, frames])
    _text("log.csv", -recording / 1e3, ",", times=True)
    adc = load("sensor.toml").design.adc
    codes = np.round(recording / adc.lsb).astype(int) + 2 ** (adc.bits - 1)
    _text("log.txt", codes, " ", times=False)
    _text("rest.txt", codes[:60], " ", times=False)
    messages = [("/skin", ARRAY, 10**9 + number, array(frame)) for number, frame in enumerate(recording)]
    bag(Path("bag"), messages, StoragePlugin.MCAP)
    return tmp_path


def _text(name: str, frames: np.ndarray, separator: str, times: bool) -> None:
    rows = frames.reshape(len(frames), -1)
    lines = [[f"{number / 100}"] * times + [f"{value:.8g}" for value in row] for number, row in enumerate(rows)]
    Path(name).write_text("".join(separator.join(line) + "\n" for line in lines))


def run(line: str) -> None:
    """Execute a ``tfra`` command, or parse one of ``LONG``."""
    words = [PLACEHOLDERS.get(word, word) for word in shlex.split(line, comments=True)[1:]]
    if words[0] in LONG or "--package" in words:
        parsed(words)
    else:
        assert main(words) == 0, line


SLOW = {
    "README.md", "docs/how_many_bits.md", "docs/development.md", "docs/howto/target.md", "docs/howto/word_lengths.md"
}
"""Pages whose cores are simulated for minutes."""

REPLAYED = {"docs/first_hour.md", "docs/tutorial.md"}
"""Pages with a test of their own that compares every answer."""

TO_COPY = [
    page for page in PAGES if page not in REPLAYED and any(line.startswith("tfra ") for line in commands(page)[0])
]


@pytest.mark.parametrize("page", [page for page in TO_COPY if page not in SLOW] + long(*sorted(SLOW)))
def test_blocks(page: str, folder: Path) -> None:
    for line in commands(page)[0]:
        if line.startswith("tfra "):
            run(line)
