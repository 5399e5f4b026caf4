"""An output is the old one or the new one, whole, at every moment; what its makers leave behind when they die goes."""

import errno
import os
import resource
import shutil
import signal
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest

from tests.marks import long
from tests.runtime.test_outputs import has, make, tree
from tfra.runtime import staging
from tfra.runtime.errors import InputError
from tfra.runtime.ownership import directory_objection, file_objection

SYSTEM_CALLS = ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.truncate", "open", "ctypes.dlsym")
"""Audit events of what changes a file system; looking a function up comes right before it is called."""


def state(out: Path) -> dict[str, object] | bytes | None:
    if not os.path.lexists(out):
        return None
    return {key.removeprefix(str(out)): value for key, value in tree(out).items()} if out.is_dir() else out.read_bytes()


def in_a_child(run: Callable[[], object]) -> int:
    """Return the number of a process that runs ``run`` and ends; none of the test's own clean-up is the child's."""
    if child := os.fork():
        return child
    code = 1
    try:
        run()
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def dies_at(step: int, run: Callable[[], object]) -> bool:
    """Run in a child process that dies before its system call number ``step``; True if it came to that."""
    count = iter(range(step))

    def hook(event: str, arguments: object) -> None:
        if event in SYSTEM_CALLS and next(count, None) is None:
            os.kill(os.getpid(), signal.SIGKILL)

    def run_with_hook() -> None:
        sys.addaudithook(hook)
        run()

    _, status = os.waitpid(in_a_child(run_with_hook), 0)
    return os.WIFSIGNALED(status)


def no_exchange(monkeypatch: pytest.MonkeyPatch) -> None:
    """A file system as NFS, which knows neither flag of renameat2."""

    def rename(source: Path, target: Path, flag: int) -> None:
        raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))

    monkeypatch.setattr(staging, "_rename", rename)


@pytest.mark.parametrize("suffix", ["", ".npz"])
@pytest.mark.parametrize(("earlier", "exchange"), [*long((False, True)), (True, True), (True, False)])
def test_death_at_every_step_leaves_old_or_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, earlier: bool, exchange: bool
) -> None:
    """Without an exchange there is nothing for a moment, until any later run puts the old one back."""
    if not exchange:
        no_exchange(monkeypatch)
    old, new, out = (tmp_path / f"{name}{suffix}" for name in ("old", "new", "out"))
    make(new, "new")
    if earlier:
        make(old, "old")
    (tmp_path / "notes.txt").write_text("mine")
    allowed, seen, absent, died = [state(new), state(old)], [], 0, True
    while died:
        if earlier:
            make(out, "old")
        died = dies_at(len(seen), lambda: make(out, "new"))
        if not exchange:
            absent += not os.path.lexists(out)
            make(tmp_path / f"beside{suffix}")
        assert state(out) in allowed, len(seen)
        seen.append(allowed.index(state(out)))
        make(out, "last")  # whoever comes next cleans up
        assert [name for name in os.listdir(tmp_path) if name.startswith(".")] == [], len(seen)
        assert (tmp_path / "notes.txt").read_text() == "mine"
        (os.unlink if suffix else shutil.rmtree)(out)
    assert len(seen) > 8
    assert seen == sorted(seen, reverse=True)  # old up to a step, new from there on
    assert set(seen) == {0, 1}
    assert bool(absent) != exchange


@contextmanager
def free_handles(count: int) -> Iterator[None]:
    """All file handles but ``count`` are in use."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    held: list[int] = []
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (200, hard))
        with suppress(OSError):
            while True:
                held.append(os.dup(0))
        for handle in held[:count]:
            os.close(handle)
        del held[:count]
        yield
    finally:
        for handle in held:
            os.close(handle)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.mark.parametrize("suffix", ["", ".npz"])
def test_nothing_stays_where_file_handles_run_out(tmp_path: Path, suffix: str) -> None:
    out, written = tmp_path / f"out{suffix}", []
    make(out, "old")
    for count in range(16):
        with free_handles(count):
            said = ""
            try:
                make(out, "new")
            except InputError as error:
                said = str(error)
        written.append(not said)
        assert said in ("", f"{out}: cannot be written: Too many open files")
        assert has(out, "old" if said else "new"), count
    assert written == sorted(written)
    assert set(written) == {False, True}


def test_a_folder_goes_without_file_handles(tmp_path: Path) -> None:
    """Whatever uses them up while it is filled."""
    with suppress(RuntimeError), ExitStack() as stack:
        stack.enter_context(free_handles(20))
        held = stack.enter_context(ExitStack())  # until the folder is gone
        new = stack.enter_context(staging.staged(tmp_path / "out", lambda place: None))
        (new / "a" / "b" / "c").mkdir(parents=True)
        (new / "a" / "b" / "c" / "core.v").touch()
        with suppress(OSError):
            while True:
                held.callback(os.close, os.dup(0))
        raise RuntimeError
    assert os.listdir(tmp_path) == []


def test_without_an_exchange_what_changes_meanwhile_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    no_exchange(monkeypatch)
    make(tmp_path / "out", "old")
    looks = []

    def objects_the_second_time(place: Path) -> None:
        looks.append(place)
        if len(looks) == 2:
            raise RuntimeError

    with pytest.raises(RuntimeError), staging.staged(tmp_path / "out", objects_the_second_time) as new:
        new.mkdir()
    assert has(tmp_path / "out", "old")


def test_a_live_owner_is_left_alone(tmp_path: Path) -> None:
    with staging.staged(tmp_path / "slow", lambda place: None) as new:
        new.mkdir()
        (new / "half").touch()
        make(tmp_path / "quick")
        assert (new / "half").exists()
    assert sorted(os.listdir(tmp_path)) == ["quick", "slow"]


def test_directories_that_only_look_like_leftovers_stay(tmp_path: Path) -> None:
    for name in (".tfra-0123abcd", ".tfra-0123abcd-01234567", ".tfra-", ".tfra"):
        (tmp_path / name / "new").mkdir(parents=True)
        (tmp_path / name / "new" / "thesis.tex").write_text("years of work")
    before = tree(tmp_path)
    make(tmp_path / "out.npz")
    (tmp_path / "out.npz").unlink()
    assert tree(tmp_path) == before


def test_what_a_leftover_holds_of_others_stays_and_is_told(tmp_path: Path) -> None:
    leftover = tmp_path / f".tfra-{staging._name('0123abcd')}"
    (leftover / "ready").mkdir(parents=True)
    (leftover / "ready" / "thesis.tex").write_text("years of work")
    (leftover / "target").symlink_to("out")
    with pytest.warns(UserWarning, match=f"^{leftover}: holds files that tfra did not write"):
        make(tmp_path / "out.npz")
    assert (leftover / "ready" / "thesis.tex").read_text() == "years of work"


def test_a_sweep_needs_no_luck_with_odd_leftovers(tmp_path: Path) -> None:
    names = [f".tfra-{staging._name(token)}" for token in ("00000000", "11111111", "22222222")]
    (tmp_path / names[0]).mkdir()
    (tmp_path / names[1]).write_text("a file")
    (tmp_path / names[2]).symlink_to(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make(tmp_path / "out.npz")
    assert sorted(os.listdir(tmp_path)) == sorted([*names[1:], "out.npz"])


@pytest.mark.parametrize(("suffix", "objection"), [("", directory_objection), (".npz", file_objection)])
def test_writers_and_a_reader_at_the_same_time(
    tmp_path: Path, suffix: str, objection: Callable[[Path], str | None]
) -> None:
    out, judged = tmp_path / f"out{suffix}", 0
    make(out, "first")
    writers = [in_a_child(lambda: [make(out, str(turn)) for turn in range(60)]) for _ in range(3)]
    while writers:
        before = out.stat()
        try:
            reason = objection(out)
        except OSError as error:
            reason = str(error)
        after = out.stat()
        if (before.st_ino, before.st_ctime_ns) == (after.st_ino, after.st_ctime_ns):  # not exchanged during the look
            assert reason is None
            judged += 1
        for writer in list(writers):
            child, status = os.waitpid(writer, os.WNOHANG)
            if child:
                assert status == 0
                writers.remove(writer)
    assert judged
    assert os.listdir(tmp_path) == [out.name]
