"""Temporary folders go with their owners; what killed ones leave goes later, and nothing of the living does."""

import errno
import fcntl
import os
from pathlib import Path

import pytest

from tests.runtime.test_staging import dies_at
from tfra.runtime import scratch as module
from tfra.runtime.errors import InputError
from tfra.runtime.scratch import locked, scratch, sweep, temporary, writing


def test_a_folder_is_there_for_its_block(tmp_path: Path) -> None:
    with scratch(tmp_path) as place, scratch(tmp_path) as other:
        assert place != other
        (place / "file").write_text("x")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(FileExistsError), scratch(tmp_path) as place:
        place.mkdir()
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_process_leaves_goes_and_what_a_living_one_has_stays(tmp_path: Path) -> None:
    def run() -> None:
        with scratch(tmp_path) as place:
            (place / "deep").mkdir()
            (place / "deep" / "file").write_text("half")

    with scratch(tmp_path) as living:
        (living / "file").write_text("half")
        kept, most, step = set(os.listdir(tmp_path)), 0, 0
        while dies_at(step, run):
            most = max(most, len(os.listdir(tmp_path)))
            sweep(tmp_path)
            assert set(os.listdir(tmp_path)) == kept
            step += 1
        assert (living / "file").read_text() == "half"
    assert most == len(kept) + 2
    assert list(tmp_path.iterdir()) == []


def test_where_there_are_no_locks_nobody_is_dead(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(module.fcntl, "flock", none)
    with scratch(tmp_path) as place:
        sweep(tmp_path)
        assert place.is_dir()
    assert list(tmp_path.iterdir()) == []


def test_who_waits_for_a_lock_gets_one_that_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file of the owner before has gone when the lock is got: the next would not meet on it."""
    flock, calls = fcntl.flock, list[int]()

    def gone(descriptor: int, how: int) -> None:
        flock(descriptor, how)
        calls.append(how)
        if len(calls) == 1:
            (tmp_path / ".tfra-a.lock").unlink()

    monkeypatch.setattr(module.fcntl, "flock", gone)
    with locked(tmp_path, "a") as held:
        assert held
        assert len(calls) == 2
        with locked(tmp_path, "a", wait=False) as also:
            assert not also
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_is_none_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError) as told, scratch(tmp_path / "nowhere"):
        pytest.fail("there is no place")
    assert str(told.value) == f"{tmp_path}/nowhere: cannot be written: No such file or directory"
    with pytest.raises(InputError) as told, writing(tmp_path):
        os.write(os.open("/dev/full", os.O_WRONLY), b"x")
    assert str(told.value) == f"{tmp_path}: cannot be written: No space left on device"

    def none() -> str:
        raise FileNotFoundError

    monkeypatch.setattr(module.tempfile, "gettempdir", none)
    with pytest.raises(InputError, match=r"^TMPDIR: no folder for temporary files can be written$"):
        temporary()
