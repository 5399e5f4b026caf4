"""Pieces of a long computation in a folder, each in a file that is written atomically.

A file is called ``NAME-HASH``, where HASH is that of the computation, the piece's name and its bytes.  So a file that
is damaged, of another computation or in another place is rejected before it is used.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from tfra.runtime.errors import InputError
from tfra.runtime.inputs import opened
from tfra.runtime.scratch import scratch, writing


@dataclass(frozen=True)
class Pieces:
    """Pieces of the computation ``key`` in ``folder``, whose names end in ``suffix``; any process may add some."""

    folder: Path
    key: str
    suffix: str

    def create(self) -> None:
        """Make the folder if it is missing; raises ``InputError``."""
        with writing(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)

    def names(self) -> set[str]:
        """Names of the existing pieces, intact or not."""
        return {file.rpartition("-")[0] for file in self._files()}

    def put(self, name: str, data: bytes) -> None:
        """Store a piece in one step; raises ``InputError`` when it can't be written."""
        put(self.folder, f"{name}-{self._digest(name, data)}{self.suffix}", data)

    def get(self, name: str) -> bytes:
        """Load a piece; raises ``InputError`` where its file is missing, damaged or another piece's."""
        files = [file for file in self._files() if file.rpartition("-")[0] == name]
        if len(files) != 1:
            reason = "there more than once: remove all of them" if files else "missing: the set is not complete"
            raise InputError(self.folder, name, f"is {reason}")
        with opened(self.folder / files[0]) as stream:
            data = stream.read()
        if files[0] != f"{name}-{self._digest(name, data)}{self.suffix}":
            reason = "is not as it was written: remove it, to have it made again"
            raise InputError(self.folder / files[0], "", reason)
        return data

    def _files(self) -> list[str]:
        try:
            return [file for file in os.listdir(self.folder) if file.endswith(self.suffix)]
        except OSError as error:
            raise InputError(self.folder, "", f"cannot be read: {error.strerror}") from None

    def _digest(self, name: str, data: bytes) -> str:
        return sha256(f"{self.key} {name}\n".encode() + data).hexdigest()[:16]


def put(folder: Path, name: str, data: bytes) -> None:
    """Write a file atomically; raises ``InputError``."""
    with scratch(folder) as place, writing(folder):
        (place / name).write_bytes(data)
        os.replace(place / name, folder / name)
