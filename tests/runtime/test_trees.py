"""Random trees of files and outputs in them: only what is a command's own changes, and whoever loses a file is caught.

The record of what was written determines which files are the program's own, not the program's opinion.  The current
directory and the home directory lie anywhere in the tree.
"""

import os
import random
import shutil
from contextlib import chdir
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest import mock

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.runtime.test_outputs import make
from tfra.runtime.errors import InputError
from tfra.runtime.ownership import MANIFEST

NAMES = (
    *("core", "out.npz", "notes.txt", "core.v", "images", ".git", ".tfra-0123abcd-0", MANIFEST, "new\nline", "p.html"),
)
TEXTS = (b"", b"years of work", b'{"generator": "tfra 0.1.0", "command": "generate", "sha256": {"notes.txt": "00"}}')

Tree = dict[str, str | bytes | None]
"""By path: a file's bytes, a link's target or what kind of thing it is, None for a directory."""


def snapshot(root: Path) -> Tree:
    """Everything below ``root``."""
    found: Tree = {}
    for path in sorted(root.rglob("*")):
        if path.is_symlink():
            found[str(path)] = f"link {os.readlink(path)}"
        elif path.is_dir():
            found[str(path)] = None
        else:
            found[str(path)] = path.read_bytes() if path.is_file() else "pipe"
    return found


def verdict(before: Tree, after: Tree, own: dict[str, bytes], target: Path, refused: bool) -> str:
    """Return the fault, if any: a refusal changes nothing, a success changes only the target."""
    if refused:
        return "" if before == after else "changed in spite of a refusal"
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


@dataclass
class Sandbox:
    """A random tree below ``root``.  ``own``: what the program wrote, by path, as it wrote it; ``outputs``: where."""

    root: Path
    rng: random.Random
    own: dict[str, bytes] = field(default_factory=dict)
    outputs: list[Path] = field(default_factory=list)

    def directory(self) -> Path:
        return self.rng.choice([self.root, *(path for path in self.paths() if path.is_dir() and not path.is_symlink())])

    def paths(self) -> list[Path]:
        return sorted(self.root.rglob("*"))

    def somebody_makes(self) -> None:
        place = self.directory() / self.rng.choice(NAMES)
        if os.path.lexists(place):
            return
        match self.rng.randrange(4):
            case 0:
                place.write_bytes(self.rng.choice(TEXTS))
            case 1:
                place.symlink_to(self.rng.choice([self.root, "..", "core", *self.paths()]))
            case 2:
                place.mkdir()
            case _:
                os.mkfifo(place)

    def somebody_changes_what_was_written(self) -> None:
        """What is moved or copied as it was written is still the program's own, and a link may lead a command to it."""
        victims = [path for path in map(Path, self.own) if path.is_file() and not path.is_symlink()]
        if not victims:
            return
        victim = self.rng.choice(victims)
        other = victim.with_name(f"other {victim.name}")
        match self.rng.randrange(6):
            case 0 | 1:
                victim.write_bytes(victim.read_bytes() + b"mine")
            case 2:
                victim.write_bytes(b"mine" + victim.read_bytes())
            case 3:
                victim.unlink()
            case 4 if not os.path.lexists(other):
                shutil.copy(victim, other)
                self.own[str(other)] = self.own[str(victim)]
            case _:
                victim.replace(other)
                self.own[str(other)] = self.own[str(victim)]
                if self.rng.randrange(2):
                    victim.symlink_to(other.name)

    def a_command_writes(self) -> None:
        anything, new = self.paths() or [self.root / "core"], self.directory() / self.rng.choice(NAMES)
        out = self.rng.choice(
            [*(self.rng.choice(self.outputs) for _ in self.outputs[:3]), self.rng.choice(anything), new]
        )
        out = out if out.suffix in ("", ".npz", ".html") else out.with_suffix("")
        command = self.rng.choice(["generate", "generate", "synth"])
        here, home = (self.rng.choice([self.root, self.root, self.directory()]) for _ in range(2))
        target, before, refused = Path(os.path.realpath(out)), snapshot(self.root), False
        with chdir(here), mock.patch.dict(os.environ, {"HOME": str(home)}):
            try:
                make(out, str(self.rng.random()), command)
            except InputError:
                refused = True
        after = snapshot(self.root)
        assert verdict(before, after, self.own, target, refused) == ""
        if not refused:
            self.outputs.append(target)
            inside = (str(target), f"{target}/")
            self.own |= {
                path: content
                for path, content in after.items()
                if isinstance(content, bytes) and (path == inside[0] or path.startswith(inside[1]))
            }


@settings(max_examples=80)
@given(st.integers(0, 10**9))
def test_random_trees(seed: int) -> None:
    with TemporaryDirectory() as directory:
        root = Path(directory).resolve() / "tree"
        root.mkdir()
        box = Sandbox(root, random.Random(seed))
        for _ in range(15):
            box.rng.choice([box.somebody_makes, box.somebody_changes_what_was_written, box.a_command_writes])()


BEFORE: Tree = {"/t/out": None, "/t/out/core.v": b"own", "/t/notes": b"mine", "/t/link": "link notes"}
OWN = {"/t/out/core.v": b"own"}


@pytest.mark.parametrize(
    ("after", "own", "refused", "fault"),
    [
        (BEFORE | {"/t/out/core.v": b"new", "/t/out/more": b""}, OWN, False, ""),
        (BEFORE | {"/t/notes": b""}, OWN, False, "lost /t/notes"),
        ({key: BEFORE[key] for key in BEFORE if key != "/t/link"}, OWN, False, "lost /t/link"),
        (BEFORE | {"/t/out/core.v": b"new"}, {}, False, "lost /t/out/core.v"),
        (BEFORE | {"/t/.tfra-0": None}, OWN, False, "left /t/.tfra-0"),
        ({key: BEFORE[key] for key in BEFORE if "out" not in key}, OWN, False, "no output"),
        (BEFORE | {"/t/out/core.v": b"new"}, OWN, True, "changed in spite of a refusal"),
    ],
)
def test_what_is_lost_or_left_is_told(after: Tree, own: dict[str, bytes], refused: bool, fault: str) -> None:
    assert verdict(BEFORE, after, own, Path("/t/out"), refused) == fault
