"""The working folder of a training: a state that is replaced every few seconds, so a kill loses only those."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

import numpy as np

from tfra import codegen, model, runtime, train
from tfra.runtime.errors import InputError
from tfra.runtime.inputs import opened
from tfra.runtime.pieces import put
from tfra.runtime.workfolder import held
from tfra.sim.run import digest, sources, texts
from tfra.train.loop import State

_HASH = sha256().digest_size


@dataclass(frozen=True)
class Work:
    """A folder, held by this process alone, with the state of any number of trainings."""

    folder: Path

    def load(self, key: str) -> tuple[int, State] | None:
        """Return the steps and the state of the training ``key``, if there is one; raises ``InputError``."""
        file = self.folder / _name(key)
        if not file.exists():
            return None
        with opened(file) as stream:
            content = stream.read()
        if content[:_HASH] != sha256(content[_HASH:]).digest():
            raise InputError(file, "", "is not as it was written: remove it, to begin again")
        with np.load(io.BytesIO(content[_HASH:]), allow_pickle=False) as held:
            arrays = {name: held[name] for name in ("vector", "mean", "square", "best")}
            curve = [(int(step), loss, error) for step, loss, error in held["curve"].tolist()]
            return int(held["steps"]), State(**arrays, step=int(held["step"]), loss=float(held["loss"]), curve=curve)

    def save(self, key: str, steps: int, state: State) -> None:
        """Replace the state of the training ``key``, which has so many ``steps``; raises ``InputError``."""
        arrays = asdict(state) | {"curve": np.array(state.curve, np.float64).reshape(-1, 3), "steps": steps}
        stream = io.BytesIO()
        np.savez(stream, allow_pickle=False, **arrays)
        put(self.folder, _name(key), sha256(stream.getbuffer()).digest() + stream.getvalue())


@contextmanager
def opened_work(folder: Path) -> Iterator[Work]:
    """Hold ``folder``; errors as for :func:`tfra.runtime.workfolder.held`."""
    with held(folder, "training", fingerprint()):
        yield Work(folder)


def _name(key: str) -> str:
    return f"{digest(key)}.state"


@cache
def fingerprint() -> str:
    """Version and sources of everything that determines the weights."""
    return digest(version("tfra"), *texts(sources(codegen, model, runtime, train)))
