"""Frame sets: a definition, and the frames that follow from it, in a folder."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import polars as pl

from tfra.codegen.config.cover import LayerSpec
from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.frames import REFERENCES, read_recording, read_references
from tfra.recordings.input import PLAIN, Input
from tfra.runtime.errors import InputError
from tfra.runtime.ownership import is_as_written
from tfra.runtime.store import Store
from tfra.study.frames.block import BLOCK, Block, Part, Stream, generator
from tfra.study.frames.mixture import Mixture
from tfra.study.frames.schema import FramesSection

ADC = Adc()
"""Of recordings that are not in codes."""


@dataclass(frozen=True, eq=False)
class Recording:
    """``frames (n, rows, columns)`` in Pa, and the known references of their contacts.

    Training frames are taken from the beginning, held-out ones from the end backwards: neighbours in time are nearly
    the same, so a random split would put every held-out contact among the training ones, too.
    """

    frames: Floats
    references: dict[str, Floats]

    @classmethod
    def read(cls, file: Path, sensor: SensorArray, adc: Adc, given: Input) -> "Recording":
        """Read a file in the format ``given``, but one of ``tfra frames`` in its own format.

        Raises ``InputError`` as ``read_recording``.
        """
        own = is_as_written(file, "frames")
        frames = read_recording(file, sensor, adc, PLAIN if own else given).frames
        return cls(frames, read_references(file, len(frames)))

    @property
    def digest(self) -> str:
        """Hash of the frames and the references."""
        hashed = sha256(self.frames.tobytes())
        for key, values in sorted(self.references.items()):
            hashed.update(key.encode() + values.tobytes())
        return hashed.hexdigest()

    def block(self, part: Part, number: int, count: int) -> Block:
        """Return the first ``count`` frames of block ``number``."""
        rows = number * BLOCK + np.arange(count)
        if part is Part.HELD_OUT:
            rows = len(self.frames) - 1 - rows
        stress = self.frames[rows].astype(np.float32)
        return Block(number * BLOCK, stress, stress, np.full_like(stress, np.nan), self._truth(rows))

    def _truth(self, rows: Ints) -> pl.DataFrame:
        known = {
            key: self.references.get(key, np.full((len(self.frames), *shape), np.nan))[rows]
            for key, shape in REFERENCES.items()
        }
        f_x, f_y, f_z = known["resultant_ref"].T
        columns = {"force_x_n": f_x, "force_y_n": f_y, "force_z_n": f_z}
        return pl.DataFrame({**columns, "mu": known["mu_ref"], "phi_deg": known["phi_ref_deg"]})


class Source(Protocol):
    """Where frames come from."""

    def block(self, part: Part, number: int, count: int) -> Block:
        """Return the first ``count`` frames of block ``number``."""


@dataclass(frozen=True)
class Definition:
    """The definition of a frame set: the sensor, its cover, a checked ``[frames]`` section, and ``size`` of a block."""

    sensor: SensorArray
    layer: LayerSpec
    section: FramesSection
    source: Source
    size: int = BLOCK

    @classmethod
    def of(
        cls,
        file: Path,
        sensor: SensorArray,
        layer: LayerSpec,
        section: FramesSection,
        adc: Adc = ADC,
        given: Input = PLAIN,
    ) -> "Definition":
        """Return the definition that the STUDY ``file`` has in ``[frames]``.

        A recording's name is relative to it; the recording is read as ``given`` says, codes as those of ``adc``.
        Raises ``InputError`` that names the file and the key.
        """
        with blame(file, "frames"):
            source = _mixture(sensor, layer, section) or _recording(file, sensor, section, adc, given)
            return cls(sensor, layer, section, source)

    @cached_property
    def document(self) -> dict[str, Any]:
        """The definition in plain values; a recording is identified by its content, not by its path."""
        section = self.section.model_dump(mode="json", by_alias=True)
        section["recording"] = self.source.digest if isinstance(self.source, Recording) else None
        layer = {"poisson": self.layer.poisson, "sampling": self.layer.sampling}
        return {"sensor": asdict(self.sensor), "layer": layer, "frames": section}

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the document."""
        return sha256(json.dumps(self.document, sort_keys=True).encode()).hexdigest()

    def frames(self, part: Part) -> int:
        """Number of frames of a part."""
        return self.section.train if part is Part.TRAIN else self.section.held_out

    def blocks(self, part: Part) -> int:
        """Number of blocks of a part."""
        return -(-self.frames(part) // self.size)

    def all_blocks(self) -> list[tuple[Part, int]]:
        """Part and number of every block, in order."""
        return [(part, number) for part in Part for number in range(self.blocks(part))]

    def count(self, part: Part, number: int) -> int:
        """Number of frames of a block."""
        return min(self.size, self.frames(part) - number * self.size)

    def make(self, part: Part, number: int) -> Block:
        """Return a block, made now."""
        return self.source.block(part, number, self.count(part, number))

    def noise(self, part: Part, number: int) -> Floats:
        """Return the noise of a block at unit deviation, ``(n, rows, columns)``: a recording has its own already."""
        shape = self.count(part, number), self.sensor.rows, self.sensor.columns
        return generator(self.section.seed, part, number, Stream.NOISE).standard_normal(shape)


@contextmanager
def blame(file: Path, section: str) -> Iterator[None]:
    """Turn ``ValueError("key: reason")`` into an ``InputError`` that names the file and the section."""
    try:
        yield
    except InputError:
        raise
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        raise InputError(file, ".".join(filter(None, (section, key))), reason) from None


def _mixture(sensor: SensorArray, layer: LayerSpec, section: FramesSection) -> Mixture | None:
    """The mixture of a section; None if it has a recording in place of it."""
    if (section.recording is None) == (not section.mixture):
        raise ValueError("mixture: either this or a recording is needed")
    if not section.train + section.held_out:
        raise ValueError("train: at least one frame of this or of held_out is needed, got none")
    if section.recording is not None:
        return None
    mixture = Mixture(sensor, layer, section.mixture, section.seed)
    if section.train and section.held_out:
        mixture.require_disjoint()
    return mixture


def _recording(file: Path, sensor: SensorArray, section: FramesSection, adc: Adc, given: Input) -> Recording:
    assert section.recording is not None
    recording = Recording.read(file.parent / section.recording, sensor, adc, given)
    wanted, have = section.train + section.held_out, len(recording.frames)
    if wanted > have:
        raise ValueError(f"train: {wanted:,} frames with those of held_out are wanted, the recording has {have:,}")
    return recording


@dataclass(frozen=True, eq=False)
class FrameSet:
    """The frames of a definition in a folder, which has a file for each block that is made.

    Any process may write any block at any time; one that is damaged, of another set or in another place is rejected
    before it is used.  A set is identified by its definition.
    """

    folder: Path
    definition: Definition

    def __repr__(self) -> str:
        return f"FrameSet({self.definition.hash})"

    def __hash__(self) -> int:
        return hash(repr(self))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FrameSet) and repr(other) == repr(self)

    @classmethod
    def create(cls, folder: Path, definition: Definition) -> "FrameSet":
        """Return the set in ``folder``, which is made if it is missing; raises ``InputError`` if it can't be."""
        frames = cls(folder, definition)
        frames._store.create()
        return frames

    def missing(self) -> list[tuple[Part, int]]:
        """Blocks that have no file yet, in order."""
        finished = self._store.names()
        return [block for block in self.definition.all_blocks() if _name(*block) not in finished]

    def write(self, block: tuple[Part, int]) -> None:
        """Make a block and store it; raises ``InputError`` when it can't be written."""
        self._store.put(_name(*block), self.definition.make(*block).to_parquet())

    def block(self, part: Part, number: int) -> Block:
        """Load a block; raises ``InputError`` where its file is missing, damaged or another block's."""
        sensor = self.definition.sensor
        data = self._store.get(_name(part, number))
        return Block.from_parquet(data, number * self.definition.size, sensor.rows, sensor.columns)

    def blocks(self, part: Part) -> Iterator[Block]:
        """Load the blocks of a part, one after the other."""
        return (self.block(part, number) for number in range(self.definition.blocks(part)))

    @property
    def _store(self) -> Store:
        return Store(self.folder, self.definition.hash)


def _name(part: Part, number: int) -> str:
    return f"{part}-{number:06d}.block"
