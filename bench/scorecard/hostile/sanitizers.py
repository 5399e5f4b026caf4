"""Cores in C and C++, and the driver's reader of frames, under the sanitizers of gcc and clang."""

import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from bench.publish import ROOT
from bench.scorecard.hostile.mutate import INTEGERS
from bench.scorecard.words.drawn import drawn
from bench.scorecard.words.harness import Configuration
from bench.scorecard.words.measure import directed
from tfra.codegen.c.files import core
from tfra.codegen.c.memory import size_of
from tfra.codegen.c.skin import skin_core
from tfra.codegen.config.read import load
from tfra.codegen.hls.files import data, files
from tfra.codegen.package.drivers import driver_files
from tfra.codegen.registers.files import register_files
from tfra.codegen.sidecar.build import sidecar
from tfra.hdl.ip.framer import FORMAT, FORMAT_PLACE
from tfra.model.arrays import Ints
from tfra.model.cover.scenes import wild_codes
from tfra.model.fixed.design import Design
from tfra.model.skin.records import record_words, records
from tfra.model.skin.skin import Skin, core_of
from tfra.sim.compiled import _calls as design_calls
from tfra.sim.compiled_skin import _calls as skin_calls

COMPILERS = ("gcc", "clang")
FLAGS = ("-std=c99", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
HLS = ("clang++", "-std=c++14", "-Wno-everything", *FLAGS[1:], "-fsanitize-ignorelist=ignored")
IGNORED = "[shift]\nsrc:*/ap_types/*\n"
"""The headers of ap_int shift negative numbers to the left."""
SEED = 10

MAIN = """
#include HEADER
#include <stdio.h>
#include <stdlib.h>
int64_t run(STATE *state, const CODE *codes, int64_t frames, int64_t *words);
/* Blocks of their size, so that a sanitizer sees what is beyond. */
int main(int count, char **given)
{
    const size_t frames = strtoul(given[1], NULL, 10), taxels = strtoul(given[2], NULL, 10);
    const size_t each = strtoul(given[3], NULL, 10), most = strtoul(given[4], NULL, 10);
    STATE *state = calloc(1, sizeof *state);
    CODE *codes = malloc(frames * taxels * sizeof *codes);
    int64_t *words = malloc(most * each * sizeof *words);
    if (count != 5 || !state || !codes || !words || fread(codes, sizeof *codes, frames * taxels, stdin) < taxels)
        return 2;
    const size_t found = (size_t)run(state, codes, (int64_t)frames, words);
    fwrite(words, sizeof *words, found * each, stdout);
    free(state);
    free(codes);
    free(words);
    return 0;
}
"""


def sources(array: Design | Skin) -> dict[str, str]:
    """Files of the core in C, with a program around it."""
    if isinstance(array, Skin):
        return skin_core(array) | {"calls.c": skin_calls(array), "main.c": MAIN}
    return core(array, sidecar(array)) | {"calls.c": design_calls(array), "main.c": MAIN}


def frames(array: Design | Skin, count: int) -> Ints:
    """Contacts, corners of the input, and ``count`` frames of noise."""
    return np.concatenate([directed(Configuration("", array)), wild_codes(array, count, SEED)])


def compared(array: Design | Skin, compiler: str, texts: Mapping[str, str], codes: Ints) -> dict[str, int | str]:
    """How many words of ``codes (n, rows, columns)`` were compared, how many differ, and what a sanitizer reports."""
    name, skin = core_of(array).name, isinstance(array, Skin)
    width = record_words(array) if isinstance(array, Skin) else array.frame_words
    most = len(codes) * (array.choices.most if isinstance(array, Skin) else 1)
    defined = [f'-DHEADER="{name}{"_skin" * skin}.h"', f"-DSTATE={name}_{'skin' if skin else 'state'}"]
    with tempfile.TemporaryDirectory() as folder:
        program = built(Path(folder), texts, [compiler, *FLAGS, *defined, f"-DCODE={name}_code"])
        given = np.ascontiguousarray(codes, dtype=f"i{size_of(array.adc.bits)}").tobytes()
        counts = [str(number) for number in (len(codes), array.sensor.taxels, width, most)]
        done = subprocess.run([program, *counts], input=given, capture_output=True, check=False, env=_environment())
    if done.returncode or done.stderr:
        return {"compared": 0, "differ": 0, "report": _first(done.stderr, done.returncode)}
    got = np.frombuffer(done.stdout, np.int64).reshape(-1, width)
    expected = records(array, codes, array.window.model.words) if isinstance(array, Skin) else array.model(codes).words
    return {"compared": expected.size, "differ": _differing(got, expected), "report": ""}


def _differing(got: Ints, expected: Ints) -> int:
    """Words that are not equal; all of them if there are more or fewer."""
    return int((got != expected).sum()) if got.shape == expected.shape else max(got.size, expected.size)


def built(folder: Path, texts: Mapping[str, str], command: Sequence[str]) -> Path:
    """The program of all sources of C among ``texts``; raises ``CalledProcessError`` where the compiler fails."""
    for file, text in texts.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text)
    units = [file for file in texts if file.endswith(".c")]
    subprocess.run([*command, "-o", "program", *units, "-lm"], cwd=folder, check=True, capture_output=True)
    return folder / "program"


def _environment() -> dict[str, str]:
    return {**os.environ, "ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=0"}


def _first(said: bytes, code: int) -> str:
    """The line of a sanitizer's report that says what it is."""
    lines = said.decode(errors="replace").splitlines()
    told = [line for line in lines if "runtime error" in line or "ERROR:" in line]
    return (told or lines or [f"exit code {code}"])[0][:300]


def driver(compiler: str, count: int) -> dict[str, int | str]:
    """``count`` changed output frames, taken apart by the driver in C; the right ones among them are read."""
    design = next(iter(drawn(2, SEED))).design
    texts = driver_files(design) | register_files(design)
    program = (ROOT / "tests/codegen/package/frames.c").read_text().replace("DESIGN", design.name)
    texts = {name: texts[name] for name in texts if name.endswith(".h")} | {
        "tfra_frame.c": texts["driver/tfra_frame.c"],
        "frames.c": program,
    }
    right = [[0, FORMAT << FORMAT_PLACE, *(word & 0xFFFFFFFF for word in words)] for words in _words(design)]
    sent, rng = list(right), Random(SEED)
    for _ in range(count):
        words = list(rng.choice(right))
        for _ in range(rng.randrange(1, 4)):
            words[rng.randrange(len(words))] = rng.choice((*INTEGERS, rng.getrandbits(32))) & 0xFFFFFFFF
        sent.append(words[: rng.choice((len(words), rng.randrange(1, len(words) + 1)))])
    text = "\n".join(f"{len(words):x} " + " ".join(f"{word:x}" for word in words) for words in sent)
    with tempfile.TemporaryDirectory() as folder:
        command = [compiler, *FLAGS, "-Idriver", "-Iregisters"]
        made = built(Path(folder), texts, command)
        done = subprocess.run([made], input=text.encode(), capture_output=True, check=False, env=_environment())
    if done.returncode or done.stderr:
        return {"compared": 0, "differ": 0, "report": _first(done.stderr, done.returncode)}
    answers = done.stdout.decode().splitlines()
    wrong = sum(not answer.startswith("0 ") for answer in answers[: len(right)]) + abs(len(answers) - len(sent))
    return {"compared": len(answers), "differ": wrong, "report": ""}


def _words(design: Design) -> list[list[int]]:
    found: list[list[int]] = design.model(directed(Configuration("", design))).words.tolist()
    return found


def hls(design: Design, count: int) -> dict[str, int | str]:
    """The core in C++ for HLS, with the headers of hls4ml: its own testbench compares the words."""
    origin = getattr(find_spec("hls4ml"), "origin", None)
    if not origin:
        return {"compared": 0, "differ": 0, "report": "hls4ml is not installed"}
    codes = frames(design, count)
    codes = codes.reshape(len(codes), -1)
    words = design.model(codes).words
    sent = {"tb_data/tb_input_features.dat": data(codes), "tb_data/tb_output_predictions.dat": data(words)}
    headers = Path(origin).parent / "templates/vivado/ap_types"
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for file, text in (files(design) | sent | {"ignored": IGNORED}).items():
            (place / file).parent.mkdir(parents=True, exist_ok=True)
            (place / file).write_text(text)
        units = [f"firmware/{design.name}.cpp", f"{design.name}_test.cpp"]
        command = [*HLS, "-isystem", str(headers), "-o", "program", *units]
        subprocess.run(command, cwd=place, check=True, capture_output=True)
        done = subprocess.run([place / "program"], cwd=place, capture_output=True, check=False, env=_environment())
    if done.returncode or done.stderr:
        return {"compared": 0, "differ": 0, "report": _first(done.stderr + done.stdout, done.returncode)}
    return {"compared": words.size, "differ": 0, "report": ""}


def campaign(count: int, noise: int, simulated: int) -> dict[str, dict[str, Any]]:
    """``count`` drawn designs and a skin in C by both compilers, ``simulated`` of them in C++, and the driver."""
    arrays: list[Design | Skin] = [one.design for one in drawn(count, SEED)]
    arrays.append(load(ROOT / "examples/fingers_32x32.toml").array)
    found: dict[str, dict[str, Any]] = {}
    for number, array in enumerate(arrays):
        kind = "skin" if isinstance(array, Skin) else array.estimator
        size = f"{array.sensor.rows}×{array.sensor.columns}"
        codes, texts = frames(array, noise), sources(array)
        for compiler in COMPILERS:
            found[f"{kind} {number}, {size}, C, {compiler}"] = compared(array, compiler, texts, codes)
    for number, array in enumerate(arrays[:simulated]):
        if isinstance(array, Design):
            found[f"{array.estimator} {number}, C++ for HLS, clang++"] = hls(array, noise // 10)
    for compiler in COMPILERS:
        found[f"driver, {compiler}"] = driver(compiler, 10 * noise)
    return found
