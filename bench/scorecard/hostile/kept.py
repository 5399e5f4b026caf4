"""Readers of results, of weights, and of files that the program keeps for itself."""

import sqlite3
from contextlib import closing, redirect_stdout
from io import StringIO
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from bench.publish import ROOT
from bench.scorecard.hostile.mutate import archived, changed_bytes, of, of_arrays
from bench.scorecard.hostile.reader import CONFIG, Prepared, Wrong, archives, configured, of_file
from tfra.cli.main import main as tfra
from tfra.codegen.config.read import load
from tfra.codegen.config.weights import COMMAND, read_weights
from tfra.recordings.frames import read_references
from tfra.runtime.outputs import output_directory
from tfra.runtime.ownership import MANIFEST, directory_objection, discard, file_objection, seal_file
from tfra.runtime.store import Store, cached, work_folder
from tfra.study.search.trials import Trial, Trials, sqlite
from tfra.view.resultfile import read_all
from tfra.view.skinfile import is_of_skin, read_skin


def result(folder: Path, text: str = CONFIG) -> list[dict[str, Any]]:
    """Frames with references, and a result of ``tfra estimate`` for them."""
    configured(folder, text)
    at = [str(folder / name) for name in ("sensor.toml", "frames.npz", "result.npz")]
    with redirect_stdout(StringIO()):
        code = tfra(["frames", at[0], "--out", at[1]]) or tfra(["estimate", *at[:2], "--out", at[2]])
    if code:
        raise Wrong("no result to begin with")
    found = []
    for file in at[1:]:
        with np.load(file) as stored:
            found.append(dict(stored))
    return found


def results_of_arrays(folder: Path) -> Prepared:
    """Results and references of ``tfra view``."""
    made = result(folder)
    return archives(made), of_file(folder / "fuzzed.npz", lambda file: read_all([folder / "result.npz", file]))


def results_of_skins(folder: Path) -> Prepared:
    """The results of a skin."""
    made = result(folder, CONFIG + "[window]\nrows = 3\ncolumns = 3\n")
    return archives(made[1:]), of_file(folder / "fuzzed.npz", lambda file: is_of_skin(file) and read_skin(file))


def references(folder: Path) -> Prepared:
    """True values beside frames."""
    made = result(folder)
    count = len(made[0]["frames"])
    return archives(made[:1]), of_file(folder / "fuzzed.npz", lambda file: read_references(file, count))


def weights(folder: Path) -> Prepared:
    """Weights: changed bytes, and changed arrays under a seal that is right."""
    config = load(ROOT / "examples" / "hertz_40x20.toml")
    source = ROOT / "examples" / "hertz_40x20.weights.npz"
    with np.load(source) as stored:
        arrays = dict(stored)
    whole, damaged = of_arrays([arrays]), of([source.read_bytes()], changed_bytes)
    file = folder / "fuzzed.npz"

    def draw(rng: Random) -> bytes:
        if not rng.randrange(4):
            return damaged(rng)
        file.write_bytes(whole(rng))
        seal_file(file, COMMAND, ".npz")
        return file.read_bytes()

    return draw, of_file(file, lambda path: read_weights(path, config.design.sensor))


def entry(folder: Path) -> Prepared:
    """Entries of the cache: one that is damaged is made again."""
    files = {"a": b"first", "b.json": b"{}"}
    path = folder / "fem-0123456789abcdef"
    cached(path, lambda: files)

    def read(data: bytes) -> None:
        path.write_bytes(data)
        if cached(path, lambda: files) != files or Store(folder).get(path.name)[-7:] != b"first{}":
            raise Wrong("a damaged entry was used")

    return of([path.read_bytes()], changed_bytes), read


def work(folder: Path) -> Prepared:
    """What the folder of a long command says of itself."""
    place = folder / "work"
    with work_folder(place, "study", "0123"):
        pass

    def read(file: Path) -> None:
        with work_folder(file.parent, "study", "0123"):
            pass

    return of([(place / "study.json").read_bytes()]), of_file(place / "study.json", read)


def trials(folder: Path) -> Prepared:
    """The table of a search's trials: changed bytes of SQLite, and changed content of a row."""
    file = folder / "trials.sqlite"
    Trials(sqlite(file), "s").add(Trial(0, "complete", {"a": 1}, {"phi": 1.5}), 0.1)
    with closing(sqlite3.connect(file)) as connection:
        connection.execute("PRAGMA journal_mode = DELETE")
        (content,) = connection.execute("SELECT content FROM trials").fetchone()
    good = file.read_bytes()
    rows, whole = of([content.encode()]), of([good], changed_bytes)

    def read(data: bytes) -> object:
        for name in ("-wal", "-shm", "-journal"):
            Path(f"{file}{name}").unlink(missing_ok=True)
        file.write_bytes(data[1:] if data[0] else good)
        if not data[0]:
            with closing(sqlite3.connect(file)) as connection, connection:
                connection.execute("UPDATE trials SET content = ?", (data[1:].decode(errors="replace"),))
        return Trials(sqlite(file), "s")()

    return lambda rng: bytes([kind := rng.randrange(2)]) + (rows, whole)[kind](rng), read


def manifest(folder: Path) -> Prepared:
    """Manifests of output folders: whatever they say, no file of a user is removed."""
    place, mine = folder / "out", folder / "mine.txt"
    with output_directory(place, "generate") as new:
        (new / "core.v").write_text("module core; endmodule")
    good = (place / MANIFEST).read_bytes()
    mine.write_text("years")
    (place / "thesis.tex").write_text("years")

    def read(data: bytes) -> None:
        place.mkdir(exist_ok=True)
        (place / "core.v").write_text("module core; endmodule")
        (place / MANIFEST).write_bytes(data)
        directory_objection(place, "generate")
        discard(place)
        if mine.read_text() + (place / "thesis.tex").read_text() != 2 * "years":
            raise Wrong("a file of a user is lost")

    more = good.replace(b"core.v", b"../mine.txt"), good.replace(b"core.v", str(mine).encode())
    return of([good, good.replace(b"core.v", b"thesis.tex"), *more]), read


def seal(folder: Path) -> Prepared:
    """Seals at the ends of outputs; a changed file is never taken for one that was written."""
    files = {suffix: folder / f"out{suffix}" for suffix in (".npz", ".vcd", ".html", ".toml")}
    for suffix, file in files.items():
        file.write_bytes(archived({"a": np.zeros(3)}) if suffix == ".npz" else b"content\n")
        seal_file(file, "estimate", suffix)
    seeds = [file.read_bytes() for file in files.values()]
    contents = [seed.rpartition(b"tfra ")[0] for seed in seeds]

    def read(file: Path) -> object:
        reason = file_objection(file, "estimate")
        if not reason and file.read_bytes().rpartition(b"tfra ")[0] not in (b"", *contents):
            raise Wrong("a changed file was taken for an output")
        return reason

    return of(seeds, changed_bytes), of_file(folder / "fuzzed", read)
