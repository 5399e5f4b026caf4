"""Random trees of files under every command's ``--out``: only the command's own files may change.

A tree holds files, links, pipes and directories of all kinds, and genuine outputs that were then tampered with.  The
current directory and the home directory lie anywhere in it.  The record of planted files determines which ones are the
program's own, not the program's opinion.  Slow steps that do not matter for files (Verilog, place and route, figures)
are replaced by stand-ins.
"""

import contextlib
import io
import os
import random
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest import mock

import numpy as np

from tests.runtime.kills import CONFIG
from tfra.cli.main import main
from tfra.runtime.outputs import output_directory, write_npz
from tfra.runtime.ownership import MANIFEST

NAMES = (
    *("core", "out", "fpga", "notes.txt", "thesis.tex", "core.json", "core.v", "images", "sensor.toml", "paper.json"),
    *("report.json", "frames.npz", "result.npz", "a.npz", ".git", ".tfra-0123abcd-0", MANIFEST, "µ x", "new\nline"),
)

TEXTS = (
    *("", "years of work", '{"generator": "tfra 0.1.0", "name": "core"}', "{}", "[", CONFIG),
    *('{"generator": "tfra 0.1.0", "command": "generate", "sha256": {"notes.txt": "00"}}',),
)

Tree = dict[str, str | bytes | None]
"""By path: a file's bytes, a link's target or what kind of thing it is, None for a directory."""


@dataclass
class Sandbox:
    """A random tree below ``root``.  ``own``: what the program wrote, by path, as it wrote it."""

    root: Path
    rng: random.Random
    own: dict[str, bytes] = field(default_factory=dict)
    planted: list[tuple[Path, str]] = field(default_factory=list)

    @property
    def directories(self) -> list[Path]:
        return [self.root, *(path for path in self.root.rglob("*") if path.is_dir() and not path.is_symlink())]

    def free_place(self) -> Path:
        place = self.rng.choice(self.directories) / self.rng.choice(NAMES)
        return self.free_place() if os.path.lexists(place) and self.rng.random() < 0.95 else place

    def populate(self) -> None:
        makers = [self._file, self._file, self._directory, self._link, self._pipe, self._recording]
        for _ in range(self.rng.randrange(8)):
            self.rng.choice(makers)()
        for _ in range(self.rng.randrange(4)):
            self.rng.choice([self._output, self._archive])()
        for _ in range(self.rng.choice([0, 0, 1, 2, 3])):
            self.rng.choice([self._tamper, self._file, self._copy])()

    def out(self, command: str) -> str:
        """A place for the output of ``command``: anything, an output of its own, or nothing yet."""
        planted = [str(place) for place, planter in self.planted if planter == command]
        anything = [".", *map(str, self.root.rglob("*"))]
        out = self.rng.choice(self.rng.choice([anything, planted or anything, [str(self.free_place())]]))
        archive = command in ("frames", "estimate") and self.rng.random() < 0.9
        return out.removesuffix(".npz") + ".npz" if archive else out

    def _new(self, make: Callable[[Path], object]) -> None:
        place = self.free_place()
        if not os.path.lexists(place):
            make(place)

    def _file(self) -> None:
        text = self.rng.choice(TEXTS).encode() + self.rng.choice([b"", self.rng.randbytes(9)])
        self._new(lambda place: place.write_bytes(text))

    def _directory(self) -> None:
        self._new(Path.mkdir)

    def _link(self) -> None:
        target = self.rng.choice([*NAMES, "..", ".", str(self.root), *map(str, self.root.rglob("*"))])
        self._new(lambda place: place.symlink_to(target))

    def _pipe(self) -> None:
        self._new(os.mkfifo)

    def _recording(self) -> None:
        self._new(lambda place: np.savez(place.with_suffix(".npz"), frames=-np.ones((1, 2, 2))))

    def _output(self) -> None:
        place, command = self.free_place(), self.rng.choice(["generate", "synth", "paper"])
        if not os.path.lexists(place):
            with output_directory(place, command) as fresh:
                (fresh / "images").mkdir()
                for name in ("core.v", "images/a.hex", "notes.txt"):
                    (fresh / name).write_bytes(self.rng.randbytes(9))
            self._remember(place, command)

    def _archive(self) -> None:
        place, command = self.free_place().with_suffix(".npz"), self.rng.choice(["frames", "estimate"])
        if not os.path.lexists(place):
            write_npz(place, {"frames": np.full((1, 2, 2), self.rng.random())}, command)
            self._remember(place, command)

    def _copy(self) -> None:
        """Copy an output, or its manifest alone: what was written stays as it was written in another place, too."""
        sources = [path for path in self.directories[1:] if (path / MANIFEST).is_file()]
        if sources and not os.path.lexists(place := self.free_place()):
            source = self.rng.choice(sources)
            if self.rng.random() < 0.5:
                shutil.copy2(source / MANIFEST, place)
            elif source not in place.parents:
                shutil.copytree(source, place, symlinks=True, ignore=_uncopied)
                copies = {str(path): path for path in place.rglob("*") if path.is_file() and not path.is_symlink()}
                origin = {name: str(source / path.relative_to(place)) for name, path in copies.items()}
                self.own |= {
                    name: path.read_bytes()
                    for name, path in copies.items()
                    if self.own.get(origin[name]) == path.read_bytes()
                }

    def _tamper(self) -> None:
        victims = [path for path in map(Path, sorted(self.own)) if path.is_file() and not path.is_symlink()]
        if not victims:
            return
        victim = self.rng.choice(victims)
        match self.rng.randrange(4):
            case 0:
                victim.write_bytes(victim.read_bytes() + b"mine")
            case 1:
                victim.unlink()
            case 2:
                self._move(victim)
            case _:
                moved = self._move(victim)
                victim.symlink_to(moved.name)

    def _move(self, victim: Path) -> Path:
        """Move what the program wrote: an archive is still its own, and a link may lead a command to it."""
        moved = victim.with_name(victim.name + " moved")
        victim.rename(moved)
        self.own[str(moved)] = moved.read_bytes()
        return moved

    def _remember(self, place: Path, command: str) -> None:
        self.planted.append((place, command))
        files = [place] if place.is_file() else [path for path in place.rglob("*") if path.is_file()]
        self.own |= {str(path): path.read_bytes() for path in files}


def _uncopied(folder: str, names: list[str]) -> list[str]:
    """What ``copytree`` can't copy."""
    return [name for name in names if Path(folder, name).is_fifo() and not Path(folder, name).is_symlink()]


def snapshot(root: Path) -> Tree:
    """Everything below ``root``."""
    found: Tree = {}
    for path in root.rglob("*"):
        if path.is_symlink():
            found[str(path)] = f"link {os.readlink(path)}"
        elif path.is_dir():
            found[str(path)] = None
        else:
            found[str(path)] = path.read_bytes() if path.is_file() else "pipe"
    return found


def verdict(before: Tree, after: Tree, own: dict[str, bytes], target: Path, code: int) -> str:
    """Return the fault, if any: a refusal changes nothing, a success changes only the target."""
    if code:
        return "" if before == after else f"changed in spite of exit code {code}"
    below = (str(target), f"{target}/")
    for path, content in before.items():
        inside = path == below[0] or path.startswith(below[1])
        foreign = content != own.get(path) and not (content in (None, b"") and inside)
        if (foreign or not inside) and (path not in after or after[path] != content):
            return f"lost {path}"
    for path in after.keys() - before.keys():
        if path != below[0] and not path.startswith(below[1]):
            return f"left {path}"
    return "" if below[0] in after else "no output"


@contextlib.contextmanager
def stand_ins() -> Iterator[None]:
    """Fast substitutes for slow steps."""

    def fill(folder: Path, *rest: Any) -> dict[str, Any]:
        (folder / "index.html").write_text("figures")
        return {}

    def few(design: Any) -> dict[str, str]:
        return {"core.v": "module", "images/a.hex": "0", f"{design.name}.json": "{}"}

    def implement(work: Any, fresh: Path) -> None:
        (fresh / "yosys.log").write_text("words")

    with contextlib.ExitStack() as stack:
        for name, substitute in {
            "tfra.codegen.generate.find_backend": lambda name: SimpleNamespace(files=few),
            "tfra.paper.report._fill": fill,
            "tfra.synth.run.Run._implement": implement,
            "tfra.synth.run.Run.report": lambda work: {},
            "tfra.synth.run.render": str,
            "tfra.synth.run.page": str,
            "tfra.synth.page.render": str,
        }.items():
            stack.enter_context(mock.patch(name, substitute))
        yield


def command_line(rng: random.Random, config: Path, frames: Path) -> list[str]:
    """A random command whose last argument, the output, is appended later."""
    return rng.choice(
        [
            ["frames", str(config), "--out", ""],
            ["estimate", str(config), str(frames), "--out", ""],
            ["generate", str(config), "--out", ""],
            ["synth", str(config), "--target", "ecp5-25", "--out", ""],
            ["paper", "--out", ""],
        ]
    )


def one_tree(seed: int) -> tuple[str, int, str]:
    """Try the tree number ``seed``: the command, its exit code, and the fault, if any."""
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as directory, stand_ins():
        root = Path(directory).resolve() / "tree"
        root.mkdir()
        sandbox = Sandbox(root, rng)
        config, frames = sandbox.free_place(), root / "frames.npz"
        config.write_text(CONFIG)
        np.savez(frames, frames=-np.ones((1, 2, 2)))
        sandbox.populate()
        words = command_line(rng, config, frames)
        words[-1] = sandbox.out(words[0])
        place, home = rng.choice(sandbox.directories), rng.choice(sandbox.directories)
        before = snapshot(root)
        with contextlib.chdir(place), mock.patch.dict(os.environ, {"HOME": str(home)}), _silence():
            target = Path(os.path.realpath(words[-1]))
            code = main(words)
        return words[0], code, verdict(before, snapshot(root), sandbox.own, target, code)


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield
