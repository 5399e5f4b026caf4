"""Cases of misuse: mistakes of users, and the answers of the commands.

To add a case, add a row to ``CASES`` and run ``python -m tests.cli.misuse.cases``, which writes the answers beside this
file.  Every command runs in a folder with ``skin.toml``, a sensor of 5 x 6 taxels with contacts, and its frames,
``frames.npz``.  A case makes its own files there.
"""

import io
import json
import os
import tempfile
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np

from tests.cli.misuse.learned import LEARNED
from tests.cli.misuse.mistakes import (
    CONFIG,
    Make,
    Misuse,
    config,
    extra,
    folder,
    nothing,
    raw,
    written,
)
from tests.cli.misuse.recordings import GOOD, NPY, NPZ, RECORDINGS, WRONG
from tests.cli.misuse.training import TRAINING
from tests.cli.misuse.views import PAGES
from tests.study.definitions import ONE_MIXTURE
from tfra.cli.main import main as tfra
from tfra.families import TARGETS
from tfra.runtime.outputs import write_npz

FILES = [
    Misuse("a pipe as CONFIG", lambda: os.mkfifo("wrong.toml"), WRONG),
    Misuse("a pipe as frames", lambda: os.mkfifo("wrong.npy"), NPY),
    Misuse("a device as CONFIG", nothing, "generate /dev/zero --out core"),
    Misuse("a folder as frames", lambda: os.mkdir("wrong.npz"), NPZ),
    Misuse("links in a circle", lambda: os.symlink("wrong.npz", "wrong.npz"), NPZ),
    Misuse("no such file", nothing, NPY),
]

DESCRIPTION = [
    Misuse("a keyword as name", config("[sensor]", 'name = "module"\n[sensor]'), WRONG),
    Misuse("a file called like a keyword", config("", "", "always.toml"), "generate always.toml --out core"),
    Misuse(
        "a keyword of VHDL as name of a package",
        config("[sensor]", 'name = "signal"\n[sensor]'),
        "generate wrong.toml --out core --package",
    ),
    Misuse("a port as name", config("[sensor]", 'name = "clk"\n[sensor]'), WRONG),
    Misuse("a mesh of 1e-6 mm", extra('[layer]\nsolver = "fem"\nelement_mm = 1e-6\n'), "frames wrong.toml --out f.npz"),
    Misuse("a cover of a micrometre", config("thickness_mm = 3", "thickness_mm = 0.001"), WRONG),
    Misuse("a slip of the unit", config("pitch_x_mm = 4", "pitch_x_mm = 4e-6"), WRONG),
    Misuse("a full scale of 1e200 Pa", extra("[adc]\nfull_scale_pa = 1e200\n"), WRONG),
    Misuse("a misspelt key", config("rows", "rwos"), WRONG),
    Misuse("thousands of hexadecimal digits", config("rows = 5", "rows = 0x" + "f" * 99_999), WRONG),
    Misuse("a key of a megabyte", extra("k" * 1_000_000 + " = 1\n"), WRONG),
    Misuse("a million dots", extra("a" + ".a" * 900_000 + " = 1\n"), WRONG),
    Misuse("too many directions", config("[0, 45, 120]", "{start = 0, stop = 360, step = 1e-6}"), WRONG),
    Misuse("a huge description", raw("wrong.toml", b"#" * 3_000_000), WRONG),
    Misuse("UTF-16 TOML", lambda: Path("wrong.toml").write_text(CONFIG, "utf-16"), WRONG),
]

OPTIONS = [
    Misuse("a billion random frames", nothing, "verify skin.toml --random 1000000000"),
    Misuse("nan frames a second", nothing, "size skin.toml --target xc7 --frames-per-second nan --latency-us 1"),
    Misuse("an unknown target", nothing, "synth skin.toml --target x --out d"),
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
    Misuse("no thickness", nothing, _INIT.format(3, 0)),
    Misuse("a line of taxels", nothing, _INIT.format(3, 3).replace("8", "1")),
    Misuse("a converter of 24 bits", nothing, f"{_INIT.format(3, 3)} --adc-bits 24"),
    Misuse("a full scale that is no number", nothing, f"{_INIT.format(3, 3)} --full-scale nan"),
    Misuse("a part that nobody knows", nothing, f"{_INIT.format(3, 3)} --target ecp5-99"),
    Misuse("a description with another suffix", nothing, f"{_INIT.format(3, 3)} --out s.txt"),
    Misuse("a description in use", nothing, f"{_INIT.format(3, 3)} --out skin.toml"),
    Misuse("an unknown example", nothing, "examples skin"),
    Misuse("examples over notes", folder("notes", thesis_tex="years"), "examples --out notes"),
    Misuse("a pitch in metres", nothing, _INIT.format(0.003, 3), code=0),
    Misuse("a full scale in kPa", nothing, f"{_INIT.format(3, 3)} --full-scale 150", code=0),
    Misuse("a pitch too fine for a core", nothing, _INIT.format(0.5, 9), code=0),
]

GENERATE = "generate skin.toml --out {}"

OUTPUTS = [
    Misuse("the current directory as output", nothing, GENERATE.format(".")),
    Misuse("a directory above", nothing, GENERATE.format("..")),
    Misuse("a folder of notes as output", folder("notes", thesis_tex="years"), GENERATE.format("notes")),
    Misuse(
        "a sidecar among notes",
        folder("notes", core_json='{"generator": "tfra 0.1.0"}', thesis_tex="years"),
        GENERATE.format("notes"),
    ),
    Misuse(
        "notes in an earlier output",
        written("generate", lambda core: (core / "notes.txt").write_text("mine")),
        GENERATE.format("core"),
    ),
    Misuse(
        "an earlier output that was edited",
        written("generate", lambda core: (core / "core.v").write_text("mine")),
        GENERATE.format("core"),
    ),
    Misuse("another command's output", written("synth", lambda core: None), GENERATE.format("core")),
    Misuse("the folder of CONFIG as output", folder("lab", skin_toml=CONFIG), "generate lab/skin.toml --out lab"),
    Misuse("the input as output", nothing, "estimate skin.toml frames.npz --out frames.npz"),
    Misuse(
        "a recording as output", lambda: np.savez("recording.npz", frames=1), "frames skin.toml --out recording.npz"
    ),
    Misuse("a table as the place of tables", raw("r.csv", b"1,2\n"), "estimate skin.toml frames.npz --out r.csv"),
    Misuse("notes as the place of a page", raw("page.html", b"<p>mine</p>"), "verify skin.toml --page page.html"),
    Misuse(
        "simulated frames as the place of results",
        lambda: write_npz("simulated.npz", {"frames": np.zeros(1)}, "frames"),
        "estimate skin.toml frames.npz --out simulated.npz",
    ),
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


STUDIES = [
    Misuse("no study", nothing, STUDY),
    Misuse("an unknown section of a study", _study("[converters]"), STUDY),
    Misuse("a study of another file", _study("", "skin.toml", "skln.toml"), STUDY),
    Misuse("friction beyond one", _study("", "mu = 0.5", "mu = 1.5"), STUDY),
    Misuse("force and peak", _study("force_n = -1.0"), STUDY),
    Misuse("a footprint larger than the array", _study("", "half_y_pitches = 1.0", "half_y_pitches = 9.0"), STUDY),
    Misuse("a search without a choice", _study("[search.space]\nscalar = []"), STUDY),
    Misuse("an unknown signal", _study("[search.space]\ncoefficient.c34 = [9, 12]"), STUDY),
    Misuse("a contradictory space", _study("[search.space]\nscalar = {from = 9, to = 8}"), STUDY),
    Misuse("an unknown cost", _study('[search]\ncosts = ["area"]'), STUDY),
    Misuse("designs to place, but no search", _study("[place]"), STUDY),
    Misuse("a scheduler that is none", _study(""), f"{STUDY} --scheduler nobody://"),
    Misuse(
        "a work folder with notes",
        lambda: (_study("")(), folder("notes", thesis_tex="years")())[-1],
        f"{STUDY} --work notes",
    ),
]

CASES = RECORDINGS + PAGES + FILES + DESCRIPTION + LEARNED + TRAINING + BEGINNING + OPTIONS + OUTPUTS + STUDIES


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
