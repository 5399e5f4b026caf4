"""Cases of misuse: mistakes of users, and the answers of the commands.

To add a case, add a row to ``CASES`` and run ``python -m tests.cli.misuse.cases``, which writes the answers beside this
file.  Every command runs in a folder with ``skin.toml``, a sensor of 5 x 6 taxels with contacts, and its frames,
``frames.npz``.  A case makes its own files there.
"""

import io
import json
import os
import tempfile
from collections.abc import Callable
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import Writer

from tests.study.definitions import ONE_MIXTURE
from tfra.cli.main import main as tfra
from tfra.codegen.config.weights import Trained, write_weights
from tfra.families import TARGETS
from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.learned.network import Weights
from tfra.model.sensor import SensorArray
from tfra.runtime.outputs import output_directory

LSB = Adc().lsb
"""Stress of a code, in Pa."""

ROWS, COLUMNS = 5, 6

CONFIG = """\
[sensor]
rows = 5
columns = 6
pitch_x_mm = 4
pitch_y_mm = 4
thickness_mm = 3
[[contact]]
shape = "hertz"
half_x_mm = 5
half_y_mm = 4
force_n = -5
mu = 0.4
phi_deg = [0, 45, 120]
"""

Make = Callable[[], object]
"""Makes files in the current folder."""


@dataclass(frozen=True)
class Misuse:
    """One case: files made, and ``arguments`` that follow ``tfra``, split at blanks.

    ``answers.json`` has what stderr shows: one line, or, with exit ``code`` 0, warnings.
    """

    name: str
    make: Make
    arguments: str
    code: int = 2


def nothing() -> None:
    """Make no file."""


def config(old: str, new: str, file: str = "wrong.toml") -> Make:
    """Make ``file``, CONFIG with ``old`` replaced."""
    assert old in CONFIG
    return lambda: Path(file).write_text(CONFIG.replace(old, new))


def extra(text: str) -> Make:
    """Make ``wrong.toml``, CONFIG with ``text`` behind it."""
    return lambda: Path("wrong.toml").write_text(CONFIG + text)


def raw(file: str, data: bytes) -> Make:
    """Make ``file`` of ``data``."""
    return lambda: Path(file).write_bytes(data)


def array(value: object) -> Make:
    """Make ``wrong.npy``."""
    return lambda: np.save("wrong.npy", np.asarray(value))


def lines(separator: str = ",", first: str = "", point: str = ".", before: str = "", n: int = 3) -> Make:
    """Make ``wrong.csv`` of ``n`` frames; ``before`` is at the start of each line, {} in it is its number."""
    frames = [separator.join(f"{value}{point}5" for value in range(30)) for _ in range(n)]
    text = first + "".join(f"{before.format(number)}{frame}\n" for number, frame in enumerate(frames))
    return raw("wrong.csv", text.encode())


def log(kind: str, topic: str) -> Make:
    """Make ``wrong.mcap`` of a message that ends early."""

    def make() -> None:
        with open("wrong.mcap", "wb") as stream:
            writer = Writer(stream)
            writer.start()
            schema = writer.register_schema(kind, "ros2msg", b"")
            channel = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channel, log_time=0, data=b"\0\1\0\0\x05", publish_time=0)
            writer.finish()

    return make


def recorded(change: Callable[[Floats], Floats]) -> Make:
    """Make ``wrong.npy``, the good frames (n, rows, columns) with something done to them."""
    return lambda: np.save("wrong.npy", change(np.load("frames.npz")["frames"]))


def codes(frames: Floats) -> Floats:
    """Signed codes of the default converter."""
    return np.rint(frames / LSB)


def noise(frames: Floats) -> Floats:
    """A sensor at rest: 0.05 % of full scale, rms."""
    return np.random.default_rng(1).normal(0, 5e-4 * Adc().full_scale, (40, ROWS, COLUMNS))


def untared(frames: Floats) -> Floats:
    """The frames after ten without a contact; every taxel has an offset of its own, 3 % of the largest magnitude."""
    offset = 0.03 * np.abs(frames).max() * np.random.default_rng(1).uniform(-1, 1, (ROWS, COLUMNS))
    return offset + np.concatenate([np.zeros((10, ROWS, COLUMNS)), frames])


def stuck(frames: Floats) -> Floats:
    """Ten loads of the first frame, and one taxel that does not move."""
    loads = np.linspace(0.2, 1, 10)[:, None, None] * frames[0]
    loads[:, 2, 3] = frames[0, 2, 3]
    return loads


def written(name: str) -> Make:
    """Make ``core``, an output of ``tfra generate`` with a file of the user's."""

    def make() -> None:
        with output_directory("core", "generate") as fresh:
            (fresh / "core.v").write_text("module core; endmodule")
        Path("core", name).write_text("mine")

    return make


def folder(file: str, text: str) -> Make:
    """Make a folder with a file."""

    def make() -> None:
        Path(file).parent.mkdir()
        Path(file).write_text(text)

    return make


notes = folder("notes/thesis.tex", "years")


ESTIMATOR = '[estimator]\nkind = "learned"\nweights = "w.npz"\n'


def weights(pitch: float = 4e-3, flipped: bool = False) -> Make:
    """Make weights for CONFIG's sensor with another ``pitch`` along x in m, or with a changed bit."""

    def make() -> None:
        Path("wrong.toml").write_text(CONFIG.replace("[[contact]]", f"{ESTIMATOR}[[contact]]"))
        shapes = (2, 30), (4, 1, 2), (4, 1), (4, 2), (4, 30)
        learned = Weights(*(np.ones(shape) for shape in shapes))
        write_weights("w.npz", Trained(SensorArray(5, 6, pitch, 4e-3, 3e-3), learned, 0.25))
        content = bytearray(Path("w.npz").read_bytes())
        content[len(content) // 2] ^= flipped
        Path("w.npz").write_bytes(content)

    return make


def unlabelled(held: dict[str, Any]) -> dict[str, Any]:
    """A result without what earlier versions did not write."""
    return {key: array for key, array in held.items() if key not in ("stress", "engine", "config")}


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


ESTIMATE = "estimate skin.toml wrong.{} --out r.npz"
NPY, NPZ, CSV, PARQUET, MCAP = (ESTIMATE.format(suffix) for suffix in ("npy", "npz", "csv", "parquet", "mcap"))
WRONG = "estimate wrong.toml frames.npz --out r.npz"
GOOD = "estimate skin.toml frames.npz --out r.npz"

RECORDINGS = [
    Misuse("rows and columns exchanged", array(np.zeros((3, COLUMNS, ROWS))), NPY),
    Misuse("times in an array", array(np.zeros((3, 31))), NPY),
    Misuse("frames along the last axis", array(np.zeros((ROWS, COLUMNS, 3))), NPY),
    Misuse("no frame", array(np.zeros((0, ROWS, COLUMNS))), NPY),
    Misuse("NaN", array(np.full((1, ROWS, COLUMNS), np.nan)), NPY),
    Misuse("beyond any stress", array(np.full((1, ROWS, COLUMNS), 1e160)), NPY),
    Misuse("no key frames", lambda: np.savez("wrong.npz", stress=1), NPZ),
    Misuse("decimal commas", lines(",", point=","), CSV),
    Misuse("points and commas", lines(";", first="1,5" + ";1" * 29 + "\n"), CSV),
    Misuse("a column of times", lines(before="0.{},"), CSV),
    Misuse("times of the clock", lines("\t", before="12:30:0{}\t"), CSV),
    Misuse("times and numbers", lines(";", before="0.{0};{0};"), CSV),
    Misuse("nothing to skip", lines(), f"{CSV} --skip-columns 1"),
    Misuse("numbered headings", lines(first=",".join(map(str, range(30))) + "\n"), CSV),
    Misuse("a digit of another script", lines(first="\u0661" + ",1" * 29 + "\n"), CSV),
    Misuse("an underscore", lines(first="1_000" + ",1" * 29 + "\n"), CSV),
    Misuse("UTF-16", raw("wrong.csv", "1,2\n".encode("utf-16")), CSV),
    Misuse("a log without frames", log("std_msgs/msg/String", "/note"), MCAP),
    Misuse("another unit", extra('[input]\nunit = "psi"\n'), WRONG),
    Misuse("two tares", extra('[input]\ntare = "a.npy"\ntare_frames = 9\n'), WRONG),
    Misuse("two tares as options", nothing, f"{GOOD} --tare a.npy --tare-frames 9"),
    Misuse("a tare longer than the recording", nothing, f"{GOOD} --tare-frames 9"),
    Misuse("a tare of another sensor", array(np.zeros((3, 7))), f"{GOOD} --tare wrong.npy"),
    Misuse("a mean that the core has not", nothing, f"{GOOD} --average 3"),
    Misuse("pascals as codes", nothing, f"{GOOD} --unit codes"),
    Misuse("offset binary as signed codes", recorded(lambda b: codes(b) + 8192), f"{NPY} --unit codes"),
    Misuse("signed codes as offset binary", recorded(codes), f"{NPY} --unit codes --coding offset"),
    Misuse("columns that are rows", nothing, f"{GOOD} --order columns"),
    Misuse("an option without frames", nothing, "verify skin.toml --unit kPa"),
]

DOUBTS = [
    Misuse("pascals as kilopascals", recorded(lambda b: b), f"{NPY} --unit kPa", 0),
    Misuse("lines along rows, read along columns", recorded(lambda b: b.reshape(3, 30)), f"{NPY} --order columns", 0),
    Misuse("the other sign", recorded(lambda b: -b), NPY, 0),
    Misuse("a sign that was turned in vain", recorded(lambda b: b), f"{NPY} --compression positive", 0),
    Misuse("kilopascals", recorded(lambda b: b / 1000), NPY, 0),
    Misuse("codes as pascals", recorded(codes), NPY, 0),
    Misuse("unipolar codes", recorded(lambda b: codes(b) + 8192), NPY, 0),
    Misuse("no tare", recorded(lambda b: b + 5000), NPY, 0),
    Misuse("a sensor at rest", recorded(noise), NPY, 0),
    Misuse("saturation", recorded(lambda b: np.maximum(9 * b, -200e3)), NPY, 0),
    Misuse("compression only", recorded(lambda b: np.minimum(b, 0)), NPY, 0),
    Misuse("one frame again and again", recorded(lambda b: b[[0] * 20]), NPY, 0),
    Misuse("offsets of single taxels", recorded(untared), NPY, 0),
    Misuse("a stuck taxel", recorded(stuck), NPY, 0),
    Misuse("over full scale", recorded(lambda b: 100 * b), f"{NPY} --engine fixed"),
    Misuse("verified over full scale", recorded(lambda b: 100 * b), "verify skin.toml --frames wrong.npy"),
]

VIEW = "view r.npz --out page.html {}"
LIVE = "live skin.toml {}"

OTHER = CONFIG.replace("pitch_y_mm = 4", "pitch_y_mm = 3")

PAGES = [
    Misuse("a result of an earlier version", result(unlabelled), VIEW.format("wrong.npz")),
    Misuse("results of two sensors", result(config=OTHER), VIEW.format("wrong.npz")),
    Misuse("a result twice", result(), VIEW.format("r.npz")),
    Misuse("a recording as a result", raw("log.csv", b"1,2,3\n"), "view log.csv --out page.html"),
    Misuse("nobody at an address", nothing, LIVE.format("tcp://127.0.0.1:1")),
    Misuse("a rate for a stream", nothing, LIVE.format("- --rate 50")),
    Misuse("a port that is none", nothing, LIVE.format("frames.npz --port 99999")),
]

CALIBRATE = "calibrate skin.toml frames.npz --loads loads.csv --out cal"

CALIBRATION = [
    Misuse("an unknown column of loads", raw("loads.csv", b"recording,force\nframes,5\n"), CALIBRATE),
    Misuse("an angle as a force", raw("loads.csv", b"recording,force_n,tangential_n\nframes,5,30\n"), CALIBRATE),
    Misuse("a load of no recording", raw("loads.csv", b"recording,force_n\nball,5\n"), CALIBRATE),
    Misuse("a load that starts at once", raw("loads.csv", b"recording,force_n\nframes,5\n"), CALIBRATE),
]

LEARNED = [
    Misuse("a learned estimator without weights", config("[sensor]", '[estimator]\nkind = "learned"\n[sensor]'), WRONG),
    Misuse("weights of another sensor", weights(pitch=3e-3), WRONG),
    Misuse("weights with a changed bit", weights(flipped=True), WRONG),
]

TRAIN = "train skin.toml --out w.npz"
_OTHER = '{"generator": "tfra 0.0.1", "sources": "0123456789abcdef"}'

TRAINING = [
    Misuse("frames as the place of weights", nothing, "train skin.toml --out frames.npz"),
    Misuse("steps and minutes", nothing, f"{TRAIN} --steps 9 --minutes 9"),
    Misuse("word lengths without weights", nothing, f"{TRAIN} --rounded"),
    Misuse(
        "a calibration of another array",
        raw("cal.toml", b'form = "tfra-calibration-1"\ndead = [[7, 0]]\n'),
        f"{TRAIN} --calibration cal.toml",
    ),
    Misuse("a training of another version", folder("old/training.json", _OTHER), f"{TRAIN} --work old"),
]

FILES = [
    Misuse("a pipe as CONFIG", lambda: os.mkfifo("wrong.toml"), WRONG),
    Misuse("a pipe as frames", lambda: os.mkfifo("wrong.npy"), NPY),
    Misuse("a folder as frames", lambda: os.mkdir("wrong.npz"), NPZ),
    Misuse("no such file", nothing, NPY),
]

DESCRIPTION = [
    Misuse("a file called like a keyword", config("", "", "always.toml"), "generate always.toml --out core"),
    Misuse("a port as name", config("[sensor]", 'name = "clk"\n[sensor]'), WRONG),
    Misuse("a mesh of 1e-6 mm", extra('[layer]\nsolver = "fem"\nelement_mm = 1e-6\n'), "frames wrong.toml --out f.npz"),
    Misuse("a misspelt key", config("rows", "rwos"), WRONG),
    Misuse("a key of a megabyte", extra("k" * 1_000_000 + " = 1\n"), WRONG),
    Misuse("UTF-16 TOML", lambda: Path("wrong.toml").write_text(CONFIG, "utf-16"), WRONG),
]

OPTIONS = [
    Misuse("a billion random frames", nothing, "verify skin.toml --random 1000000000"),
    Misuse("nan frames a second", nothing, "size skin.toml --target xc7 --frames-per-second nan --latency-us 1"),
    Misuse(
        "a frame rate that no core reaches",
        nothing,
        "size skin.toml --target ecp5-25 --frames-per-second 1e9 --latency-us 100",
    ),
    Misuse("an output with another suffix", nothing, "frames skin.toml --out f.csv"),
    Misuse("a result with another suffix", nothing, f"{GOOD[:-4]}.xlsx"),
]

_INIT = "init --rows 8 --columns 12 --pitch-x {} --pitch-y 2.5 --thickness {}"

BEGINNING = [
    Misuse("a line of taxels", nothing, _INIT.format(3, 3).replace("8", "1")),
    Misuse("a full scale that is no number", nothing, f"{_INIT.format(3, 3)} --full-scale nan"),
    Misuse("a part that nobody knows", nothing, f"{_INIT.format(3, 3)} --target ecp5-99"),
    Misuse("a description in use", nothing, f"{_INIT.format(3, 3)} --out skin.toml"),
    Misuse("an unknown example", nothing, "examples skin"),
    Misuse("examples over notes", notes, "examples --out notes"),
    Misuse("a pitch in metres", nothing, _INIT.format(0.003, 3), 0),
    Misuse("a full scale in kPa", nothing, f"{_INIT.format(3, 3)} --full-scale 150", 0),
    Misuse("a pitch too fine for a core", nothing, _INIT.format(0.5, 9), 0),
]

GENERATE = "generate skin.toml --out {}"

OUTPUTS = [
    Misuse("the current directory as output", nothing, GENERATE.format(".")),
    Misuse("a folder of notes as output", notes, GENERATE.format("notes")),
    Misuse("notes in an earlier output", written("notes.txt"), GENERATE.format("core")),
    Misuse("an earlier output that was edited", written("core.v"), GENERATE.format("core")),
    Misuse("the folder of CONFIG as output", folder("lab/skin.toml", CONFIG), "generate lab/skin.toml --out lab"),
    Misuse("the input as output", nothing, "estimate skin.toml frames.npz --out frames.npz"),
    Misuse("notes as the place of a page", raw("page.html", b"<p>mine</p>"), "verify skin.toml --page page.html"),
]

STUDY = "study study.toml --out report"
_STUDY = f"""
config = "skin.toml"
[frames]
train = 400
held_out = 400
{ONE_MIXTURE}"""


def _study(more: str, old: str = "", new: str = "") -> Make:
    """``study.toml`` with lines more, and a part replaced."""
    return raw("study.toml", (_STUDY.replace(old, new) + more).encode())


def _study_of_skin(more: str, contacts: str = "1") -> Make:
    """The same of the sensor as a skin with windows of 4 x 4 taxels, and so many contacts."""
    skin = config("[[contact]]", "[window]\nrows = 4\ncolumns = 4\n[[contact]]", "hand.toml")
    text = _STUDY.replace("skin.toml", "hand.toml") + f"contacts = {contacts}\n{more}"
    return lambda: (skin(), raw("study.toml", text.encode())())


STUDIES = [
    Misuse("an unknown section of a study", _study("[converters]"), STUDY),
    Misuse("an unknown signal", _study("[search.space]\ncoefficient.c34 = [9, 12]"), STUDY),
    Misuse("a search on a skin", _study_of_skin("[search]"), STUDY),
    Misuse("more contacts than are found", _study_of_skin("", "{from = 1, to = 20}"), STUDY),
    Misuse("contacts of one array", _study("contacts = 3"), STUDY),
    Misuse("a scheduler that is none", _study(""), f"{STUDY} --scheduler nobody://"),
    Misuse("a work folder with notes", lambda: (_study("")(), notes()), f"{STUDY} --work notes"),
]

CASES = [
    *RECORDINGS, *DOUBTS, *PAGES, *FILES, *DESCRIPTION, *CALIBRATION, *LEARNED, *TRAINING, *BEGINNING, *OPTIONS,
    *OUTPUTS, *STUDIES,
]  # fmt: skip


def answer(case: Misuse, frames: bytes) -> tuple[int, str, str]:
    """Run ``case`` in the current folder, which is empty: exit code, standard output and standard error.

    The parts that synthesis knows stand as ``…``: a new family changes no answer.
    """
    Path("skin.toml").write_text(CONFIG)
    Path("frames.npz").write_bytes(frames)
    case.make()
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        code = tfra(case.arguments.split())
    return code, out.getvalue(), err.getvalue().replace(", ".join(TARGETS), "…")


def good_frames() -> bytes:
    """The content of ``frames.npz``."""
    with tempfile.TemporaryDirectory() as place, chdir(place), redirect_stdout(io.StringIO()):
        Path("skin.toml").write_text(CONFIG)
        tfra(["frames", "skin.toml", "--out", "frames.npz"])
        return Path("frames.npz").read_bytes()


ANSWERS = Path(__file__).with_name("answers.json")
"""What the commands say, by the names of the cases."""


def main() -> None:
    """Run every case and write the answers."""
    frames, answers = good_frames(), {}
    for case in CASES:
        with tempfile.TemporaryDirectory() as place, chdir(place):
            answers[case.name] = answer(case, frames)[2]
    ANSWERS.write_text(json.dumps(answers, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
