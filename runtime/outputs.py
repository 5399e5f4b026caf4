"""Output that is complete or absent, and never replaces a file that this program did not write."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.runtime.errors import InputError
from tfra.runtime.ownership import directory_objection, file_objection, seal_directory, seal_file
from tfra.runtime.scratch import writing
from tfra.runtime.staging import staged

_ADVICE = "move it away, or choose another place"

Objection = Callable[[Path, str], str | None]
"""Function that states why a command must not replace the file at a path."""


def check_file(path: str | Path, suffix: str, command: str, inputs: Sequence[Path] = ()) -> None:
    """Raise ``InputError`` now if a file can't be written at ``path``, whose name must end in ``suffix``.

    It must not be one of ``inputs`` either.  Call it before a long computation.
    """
    if Path(path).suffix != suffix:
        raise InputError(path, "", f"the name of the output must end in {suffix}")
    with writing(path), suppress(_Rehearsal):
        target = _real(path)
        there = [file for file in inputs if file.exists()] if target.exists() else []
        if target in map(_real, inputs) or any(map(target.samefile, there)):
            raise InputError(path, "", "is not replaced: this command reads it: choose another place")
        with staged(target, _check(path, file_objection, command)) as new:
            new.touch()
            raise _Rehearsal


def check_directory(path: str | Path, command: str, inputs: Sequence[Path] = ()) -> None:
    """Raise ``InputError`` now if ``output_directory`` would."""
    with suppress(_Rehearsal), output_directory(path, command, inputs):
        raise _Rehearsal


def write_npz(path: str | Path, arrays: Mapping[str, npt.NDArray[Any]], command: str) -> None:
    """Write ``arrays`` as an uncompressed .npz; equal arrays give equal bytes (no dates, no pickles).

    ``path`` may be missing, empty, or what the same ``command`` wrote, as it wrote it.  Anything else is left alone.
    Raises ``InputError`` then, and when the file can't be written.
    """
    with _output_file(path, command, ".npz") as new, open(new, "xb") as stream:
        np.savez(stream, allow_pickle=False, **dict(arrays))


def write_text(path: str | Path, text: str, command: str) -> None:
    """Write a page (.html) or a CONFIG file (.toml), bytes of names that are no UTF-8 escaped.

    ``path`` and errors as for ``write_npz``.
    """
    with _output_file(path, command, Path(path).suffix) as new:
        new.write_text(text, encoding="utf-8", errors="backslashreplace", newline="\n")


def write_vcd(path: str | Path, waves: Path, command: str) -> None:
    """Write a copy of the VCD file ``waves``; ``path`` and errors as for ``write_npz``."""
    with _output_file(path, command, ".vcd") as new:
        shutil.copyfile(waves, new)


@contextmanager
def _output_file(path: str | Path, command: str, suffix: str) -> Iterator[Path]:
    """Yield a free path; the file that the block makes there is sealed and becomes ``path``."""
    with writing(path), staged(_real(path), _check(path, file_objection, command)) as new:
        yield new
        seal_file(new, command, suffix)


@contextmanager
def output_directory(path: str | Path, command: str, inputs: Sequence[Path] = ()) -> Iterator[Path]:
    """Make an empty directory, which takes the place of ``path`` when the block ends without an exception.

    ``path`` may be missing, empty, or what the same ``command`` wrote, as it wrote it.  Anything else is left alone,
    and so is a directory with one of ``inputs``, the current one, the home directory, and those above them.  Raises
    ``InputError`` then, and when the directory can't be written.
    """
    with writing(path):
        target = _real(path)
        if os.path.lexists(target):
            _check_place(path, target, inputs)
        with staged(target, _check(path, directory_objection, command)) as new:
            new.mkdir()
            yield new
            seal_directory(new, command)


def _check(path: str | Path, objection: Objection, command: str) -> Callable[[Path], None]:
    def check(place: Path) -> None:
        if reason := objection(place, command):
            raise InputError(path, "", f"is not replaced: {reason}: {_ADVICE}")

    return check


def _check_place(path: str | Path, target: Path, inputs: Sequence[Path]) -> None:
    needed = {"the current directory": _existing(Path.cwd), "the home directory": _existing(Path.home)}
    needed |= {f"{file}, which this command reads": _real(file) for file in inputs}
    for what, place in needed.items():
        if place is not None and target in (place, *place.parents):
            relation = "is" if place == target else "holds"
            raise InputError(path, "", f"is not replaced: it {relation} {what}: choose another place")


class _Rehearsal(Exception):
    pass


def _real(path: str | Path) -> Path:
    return Path(os.path.realpath(path))


def _existing(find: Callable[[], Path]) -> Path | None:
    try:
        return find().resolve()
    except (OSError, RuntimeError):  # it has been removed, or there is none
        return None
