"""What a cache holds is what was put there, or it is made again."""

import inspect
import multiprocessing
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import chdir, suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.runtime.test_staging import dies_at
from tfra import runtime
from tfra.runtime import store as module
from tfra.runtime.digest import digest, sources
from tfra.runtime.errors import InputError
from tfra.runtime.scratch import part, scratch
from tfra.runtime.store import Files, Store, cache_directory, cached, cached_step, work_folder

FILES = {"top.v": b"module top;\nendmodule\n", "empty": b"", "image.hex": bytes(range(256)) * 9}


class Maker:
    """Makes ``files`` and counts how often."""

    def __init__(self, files: Files = FILES) -> None:
        self.files, self.calls = files, 0

    def __call__(self) -> Files:
        self.calls += 1
        return self.files


def _folder(place: Path) -> None:
    (place / "obj").mkdir(parents=True)
    (place / "obj" / "top.v").write_text("module top; endmodule")


def _socket(place: Path) -> None:
    with chdir(place.parent), socket.socket(socket.AF_UNIX) as bound:  # names of sockets are short
        bound.bind("s")
        os.rename("s", place.name)


def _lock(entry: Path) -> Path:
    return entry.with_name(f".tfra-{entry.name}.lock")


DAMAGES: dict[str, Callable[[Path], object]] = {
    "missing": lambda entry: None,
    "zeros": lambda entry: entry.write_bytes(bytes(2400)),
    "text": lambda entry: entry.write_bytes(b"nothing to see here\n" * 100),
    "another entry": lambda entry: entry.write_bytes((entry.parent / "core-another").read_bytes()),
    "an empty folder": Path.mkdir,
    "a full folder": _folder,
    "a locked folder": lambda entry: (_folder(entry), entry.chmod(0)),
    "a dangling link": lambda entry: entry.symlink_to("nowhere"),
    "a link to itself": lambda entry: entry.symlink_to(entry.name),
    "a link to a device": lambda entry: entry.symlink_to("/dev/zero"),
    "a pipe": os.mkfifo,
    "a socket": _socket,
    "unreadable": lambda entry: (entry.write_bytes(b""), entry.chmod(0)),
    "a lock that nobody holds": lambda entry: _lock(entry).touch(),
    "an unreadable lock": lambda entry: (_lock(entry).touch(), _lock(entry).chmod(0)),
    "a folder as lock": lambda entry: _lock(entry).mkdir(),
    "a link as lock": lambda entry: _lock(entry).symlink_to("nowhere"),
    "half an entry of a killed run": lambda entry: part(entry.parent, entry.name).write_bytes(b"half"),
    "a folder of a killed run": lambda entry: _folder(part(entry.parent, entry.name)),
}
"""What stands in the place of an entry that is gone, or beside it."""


def damaged(entry: Path, damage: Callable[[Path], object]) -> None:
    entry.unlink()
    damage(entry)


@given(st.dictionaries(st.text(), st.binary()))
@settings(max_examples=30)
def test_an_entry_gives_back_what_was_made(files: Files) -> None:
    with tempfile.TemporaryDirectory() as folder:
        place, make = Path(folder, "core-x"), Maker(files)
        assert [cached(place, make) for _ in range(3)] == [files] * 3
        assert make.calls == 1
        assert list(place.parent.iterdir()) == [place]


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_entry_is_made_again(tmp_path: Path, damage: Callable[[Path], object]) -> None:
    place, make = tmp_path / "core-x", Maker()
    cached(tmp_path / "core-another", Maker({"a": b"b"}))
    cached(place, make)
    damaged(place, damage)
    assert [cached(place, make) for _ in range(2)] == [FILES] * 2
    assert make.calls == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["core-another", "core-x"]


def test_no_wrong_bit_and_no_wrong_length_passes(tmp_path: Path) -> None:
    place, make = tmp_path / "core-x", Maker({"a": b"some words"})
    cached(place, make)
    content = place.read_bytes()
    flipped = [content[:at] + bytes([content[at] ^ 1 << at % 8]) + content[at + 1 :] for at in range(len(content))]
    for wrong in [*flipped, *(content[:end] for end in range(len(content))), content + b"\0"]:
        place.write_bytes(wrong)
        assert cached(place, make) == make.files
    assert make.calls == 2 + 2 * len(content)


def test_death_at_every_step_leaves_nothing_that_the_next_does_not_remove(tmp_path: Path) -> None:
    place, step = tmp_path / "core-x", 0
    while dies_at(step, lambda: (cached(place, Maker()), module.put(tmp_path, "note", b"n"))):
        step += 1
        assert cached(place, Maker()) == FILES
        with scratch(tmp_path):
            pass
        assert {path.name for path in tmp_path.iterdir()} <= {"core-x", "note"}
        place.unlink()
    assert step > 8


def test_what_a_link_leads_to_stays(tmp_path: Path) -> None:
    own = tmp_path / "own"
    own.mkdir()
    (own / "thesis.txt").write_text("years of work")
    cache = tmp_path / "cache"
    cache.mkdir()
    for name in ("core-x", ".tfra-core-x.lock", ".tfra-core-x.part"):
        (cache / name).symlink_to(own)
    assert cached(cache / "core-x", Maker()) == FILES
    assert [path.name for path in cache.iterdir()] == ["core-x"]
    assert (own / "thesis.txt").read_text() == "years of work"


def test_only_what_is_its_own_is_removed(tmp_path: Path) -> None:
    strangers = {".part", ".lock", "a.part", ".tfra.part", "tfra-a.lock", ".git", "run-1", "core-y"}
    for name in strangers:
        (tmp_path / name).write_text("mine")
    cached(tmp_path / "core-x", Maker())
    with scratch(tmp_path):
        pass
    assert {path.name for path in tmp_path.iterdir()} == {*strangers, "core-x"}


def test_of_many_at_once_one_makes_it(tmp_path: Path) -> None:
    make = Maker()

    def slow() -> Files:
        time.sleep(0.05)
        return make()

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: cached(tmp_path / "core-x", slow), range(8)))
    assert found == [FILES] * 8
    assert make.calls == 1
    assert [path.name for path in tmp_path.iterdir()] == ["core-x"]


def _want(place: Path, seed: int) -> None:
    damages = list(DAMAGES.values())
    for turn in range(25):
        assert cached(place, lambda: FILES) == FILES
        if turn % 3 == 0:
            with suppress(OSError):  # another was faster
                damaged(place, damages[(seed + turn) % len(damages)])


def test_processes_that_damage_and_want_the_same_get_it(tmp_path: Path) -> None:
    """Right at every look, while others replace it, break it, and take the locks away."""
    spawn = multiprocessing.get_context("spawn")
    cached(tmp_path / "core-another", Maker({"a": b"b"}))
    workers = [spawn.Process(target=_want, args=(tmp_path / "core-x", 7 * seed)) for seed in range(3)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert [worker.exitcode for worker in workers] == [0, 0, 0]


def test_a_failure_leaves_nothing_and_is_made_again(tmp_path: Path) -> None:
    def fail(failure: Exception) -> Files:
        raise failure

    for failure, error, line in (
        (ArithmeticError("no"), ArithmeticError, "no"),
        (OSError(28, "No space left on device"), InputError, f"{tmp_path}: cannot be written: No space left on device"),
    ):
        with pytest.raises(error) as caught:
            cached(tmp_path / "core-x", lambda failure=failure: fail(failure))
        assert str(caught.value) == line
        assert list(tmp_path.iterdir()) == []
    assert cached(tmp_path / "core-x", Maker()) == FILES


def test_an_entry_that_cannot_be_stored_is_used_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module.os, "replace", full)
    with pytest.warns(UserWarning, match=r"core-x: not kept for the next run: No space left on device$"):
        assert cached(tmp_path / "core-x", Maker()) == FILES
    assert list(tmp_path.iterdir()) == []


# Steps of tools


def test_a_step_runs_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TFRA_CACHE", str(tmp_path / "cache"))
    calls = []

    def step(directory: Path) -> dict[str, Any]:
        calls.append(directory)
        (directory / "tool.log").write_bytes(b"\x00words\n" * 1000)
        return {"mhz": 1.5, "path": {"begin": "sweep"}}

    first, second = tmp_path / "first", tmp_path / "second"
    for directory, was_kept in ((first, False), (second, True)):
        directory.mkdir()
        (directory / "before").write_text(directory.name)
        found = cached_step("yosys-skin", "0" * 16, directory, lambda directory=directory: step(directory))
        assert found == ({"mhz": 1.5, "path": {"begin": "sweep"}}, was_kept)
    assert calls == [first]
    assert (second / "tool.log").read_bytes() == (first / "tool.log").read_bytes()
    assert (second / "before").read_text() == "second"
    cached_step("yosys-skin", "1" * 16, second, lambda: step(second))
    assert calls == [first, second]


def test_a_digest_depends_on_every_part_and_all_sources() -> None:
    assert len({digest(*parts) for parts in ((), ("",), ("a", "b"), ("b", "a"), ("ab",), ("a", "b", ""))}) == 6
    found = sources(runtime)
    assert {inspect.getsource(module), inspect.getsource(sys.modules[digest.__module__])} <= set(found)


# Results of one computation


def test_a_result_of_another_computation_name_or_content_is_rejected(tmp_path: Path) -> None:
    store = Store(tmp_path / "pieces", "a key")
    store.create()
    store.put("one", b"old")
    store.put("one", b"data")
    assert (store.get("one"), store.names()) == (b"data", {"one"})
    content = (store.folder / "one").read_bytes()
    assert content.endswith(b"data")
    (store.folder / "two").write_bytes(content)
    (store.folder / "three").write_bytes(content[:-1] + b"b")
    wrong = [(store, "two"), (store, "three"), (Store(store.folder, "another"), "one")]
    for each, name in wrong:
        with pytest.raises(InputError) as caught:
            each.get(name)
        assert str(caught.value) == f"{store.folder / name}: is not as it was written: remove it, to have it made again"
    with pytest.raises(InputError, match=r"four: cannot be read: No such file or directory$"):
        store.get("four")
    with pytest.raises(InputError, match=r"pieces/none: cannot be read: No such file or directory$"):
        Store(store.folder / "none").names()


def test_a_work_folder_is_of_one_kind_and_one_state_of_the_sources(tmp_path: Path) -> None:
    folder = tmp_path / "w"
    for _ in range(2):
        with (
            work_folder(folder, "study", "hash"),
            pytest.raises(InputError, match="w: is in use by another run: "),
            work_folder(folder, "study", "hash"),
        ):
            pytest.fail("two at once")
    for kind, source, reason in (
        ("training", "hash", "is not the folder of a training: "),
        ("study", "another", "has work of tfra .* with other sources, which is kept: "),
    ):
        with pytest.raises(InputError, match=reason), work_folder(folder, kind, source):
            pytest.fail("another's folder")
    assert [path.name for path in folder.iterdir()] == ["study.json"]


# Where it is


def test_places(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("TFRA_CACHE", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_directory() == tmp_path / "home" / ".cache" / "tfra"
    monkeypatch.setenv("TFRA_CACHE", str(tmp_path / "a"))
    assert cache_directory() == tmp_path / "a"
    assert cache_directory(tmp_path / "b") == tmp_path / "b"
    assert all(place.is_dir() for place in (tmp_path / "home" / ".cache" / "tfra", tmp_path / "a", tmp_path / "b"))


@pytest.mark.parametrize("below", ["", "deeper"])
def test_a_named_place_that_cannot_be_used_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, below: str) -> None:
    (tmp_path / "file").write_text("mine")
    place = tmp_path / "file" / below
    monkeypatch.setenv("TFRA_CACHE", str(place))
    for chosen, name in ((place, place), (None, f"TFRA_CACHE: {place}")):
        with pytest.raises(InputError) as caught:
            cache_directory(chosen)
        assert str(caught.value) == f"{name}: cannot be used as cache: Not a directory"
    assert (tmp_path / "file").read_text() == "mine"
    monkeypatch.setattr(module.os, "access", lambda *_: False)  # for root everything can be
    with pytest.raises(InputError, match=r"cannot be used as cache: it cannot be written$"):
        cache_directory(tmp_path)


@pytest.mark.parametrize("home", ["/dev/null", "/proc/nowhere"])
def test_without_a_default_place_there_is_a_private_one(tmp_path: Path, home: str) -> None:
    """One warning, one place in a process, and nothing left of it."""
    script = """
import pathlib, warnings
from tfra.runtime.store import cache_directory
warnings.showwarning = lambda message, *_: print(message)
place = cache_directory()
assert place == cache_directory()
(place / "core-x").write_text("")
print(place)
"""
    variables = {key: value for key, value in os.environ.items() if key != "TFRA_CACHE"}
    variables |= {"HOME": home, "TMPDIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", script], env=variables, capture_output=True, text=True, check=True)
    warning, place = done.stdout.splitlines()
    assert warning.startswith("no cache in ~/.cache/tfra, nothing is kept between runs: ")
    assert Path(place).parent == tmp_path
    assert list(tmp_path.iterdir()) == []


def entry(folder: Path, number: int, size: int, last_use: int) -> Path:
    """An entry of ``size`` bytes and a little more that was used so many seconds after 1970."""
    place = folder / f"core-c-{number:016x}"
    cached(place, Maker({"a": bytes(size)}))
    os.utime(place, (last_use, last_use))
    return place


def test_the_longest_unused_entries_go_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TFRA_CACHE_MB", "1")
    first, second, third = (entry(tmp_path, number, 300_000, 10 + number) for number in range(3))
    foreign = [tmp_path / "core-notes.txt", tmp_path / "thesis.tex", tmp_path / f"core-{7:016x}"]
    for file in foreign[:2]:
        file.write_bytes(bytes(2_000_000))
    foreign[2].symlink_to(foreign[1])
    assert cached(first, Maker()) == {"a": bytes(300_000)}  # used now
    entry(tmp_path, 3, 300_000, 20)
    assert [place.exists() for place in (first, second, third)] == [True, False, True]
    assert all(file.exists() for file in foreign)
    entry(tmp_path, 4, 1_500_000, 30)  # larger than the limit: it alone stays
    assert sorted(place.name for place in tmp_path.glob("core-c-*")) == [f"core-c-{4:016x}"]
    assert all(file.exists() for file in foreign)


@pytest.mark.parametrize("value", ["", "0", "-1", "many", "1.5", "\u00b2", "9" * 5000])
def test_a_limit_that_is_no_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    monkeypatch.setenv("TFRA_CACHE_MB", value)
    with pytest.raises(InputError, match=r"^TFRA_CACHE_MB: a whole number of megabytes above 0 is needed, got "):
        cached(tmp_path / "core-x", Maker())
    assert not list(tmp_path.iterdir())


def test_two_that_prune_at_once_lose_nothing_that_is_wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TFRA_CACHE_MB", "1")

    def want(number: int) -> Files:
        return cached(tmp_path / f"core-c-{number % 9:016x}", Maker({"a": bytes([number % 9]) * 200_000}))

    with ThreadPoolExecutor(4) as pool:
        made = pool.map(want, range(90))
        assert [files["a"][:1] for files in made] == [bytes([n % 9]) for n in range(90)]
    assert sum(place.stat().st_size for place in tmp_path.iterdir()) <= 1_000_000
