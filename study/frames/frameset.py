"""Frame sets: a definition, and the frames that follow from it, in a folder.

A folder holds ``definition.json`` and a :class:`tfra.runtime.store.Store` of the definition with a file for each block,
``PART-NUMBER.block``, so one that is damaged, of another set or in another place is rejected before it is used.  Any
process may write any block at any time, and the set is complete when all blocks exist.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

from tfra.codegen.config.cover import LayerSpec
from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.input import PLAIN, Input
from tfra.runtime.errors import InputError
from tfra.runtime.inputs import opened
from tfra.runtime.scratch import writing
from tfra.runtime.store import Store, put
from tfra.study.frames.block import BLOCK, Block, Part, Stream, generator
from tfra.study.frames.mixture import Mixture
from tfra.study.frames.recording import Recording
from tfra.study.frames.schema import FramesSection

_DEFINITION = "definition.json"

ADC = Adc()
"""Of recordings that are not in codes."""


@dataclass(frozen=True)
class Definition:
    """The definition of a frame set: the sensor, its cover, and a checked ``[frames]`` section."""

    sensor: SensorArray
    layer: LayerSpec
    section: FramesSection
    source: Mixture | Recording

    @classmethod
    def of(
        cls,
        file: Path,
        sensor: SensorArray,
        layer: LayerSpec,
        section: FramesSection,
        adc: Adc = ADC,
        given: Input = PLAIN,
    ) -> Definition:
        """Return the definition that the STUDY ``file`` has in ``[frames]``.

        A recording's name is relative to it; the recording is read as ``given`` says, codes as those of ``adc``.
        Raises ``InputError`` that names the file and the key.
        """
        try:
            source = _mixture(sensor, layer, section) or _recording(file, sensor, section, adc, given)
            return cls(sensor, layer, section, source)
        except InputError:
            raise
        except ValueError as error:
            key, _, reason = str(error).partition(": ")
            raise InputError(file, f"frames.{key}", reason) from None

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
        return _hash(self.document)

    def frames(self, part: Part) -> int:
        """Number of frames of a part."""
        return self.section.train if part is Part.TRAIN else self.section.held_out

    def blocks(self, part: Part) -> int:
        """Number of blocks of a part."""
        return -(-self.frames(part) // BLOCK)

    def count(self, part: Part, number: int) -> int:
        """Number of frames of a block."""
        return min(BLOCK, self.frames(part) - number * BLOCK)

    def make(self, part: Part, number: int) -> Block:
        """Return a block, made now."""
        return self.source.block(part, number, self.count(part, number))

    def noise(self, part: Part, number: int) -> Floats:
        """Return the noise of a block at unit deviation, ``(n, rows, columns)``: a recording has its own already."""
        shape = self.count(part, number), self.sensor.rows, self.sensor.columns
        return generator(self.section.seed, part, number, Stream.NOISE).standard_normal(shape)


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


@dataclass(frozen=True)
class FrameSet:
    """The frames of a definition in a folder."""

    folder: Path
    definition: Definition

    def __repr__(self) -> str:
        """Identified by its content, not by its path."""
        return f"FrameSet({self.definition.hash})"

    @classmethod
    def create(cls, folder: Path, definition: Definition) -> FrameSet:
        """Return the set in ``folder``, which is made if it is missing; frames may be missing in it.

        Raises ``InputError`` if it has files of another definition, or can't be written.
        """
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        if not os.path.lexists(folder / _DEFINITION):
            content = {"sha256": definition.hash, "definition": definition.document}
            put(folder, _DEFINITION, (json.dumps(content, indent=1) + "\n").encode())
        return cls.open(folder, definition)

    @classmethod
    def open(cls, folder: Path, definition: Definition) -> FrameSet:
        """Return the set in ``folder``; raises ``InputError`` where it isn't one of ``definition``."""
        found = _read_definition(folder / _DEFINITION)
        if found != definition.document:
            key = _first_difference(found, definition.document)
            raise InputError(folder, "", f"holds frames of another definition: {key} differs")
        return cls(folder, definition)

    def missing(self) -> list[tuple[Part, int]]:
        """Blocks that have no file yet, in order."""
        there = self._store.names()
        every = ((part, number) for part in Part for number in range(self.definition.blocks(part)))
        return [(part, number) for part, number in every if _name(part, number) not in there]

    def write(self, part: Part, number: int) -> None:
        """Make a block and store it; raises ``InputError`` when it can't be written."""
        self._store.put(_name(part, number), self.definition.make(part, number).to_parquet())

    def complete(self) -> None:
        """Make and store all missing blocks."""
        for part, number in self.missing():
            self.write(part, number)

    def block(self, part: Part, number: int) -> Block:
        """Load a block; raises ``InputError`` where its file is missing, damaged or another block's."""
        sensor = self.definition.sensor
        data = self._store.get(_name(part, number))
        return Block.from_parquet(data, number * BLOCK, sensor.rows, sensor.columns)

    def blocks(self, part: Part) -> Iterator[Block]:
        """Load the blocks of a part, one after the other."""
        return (self.block(part, number) for number in range(self.definition.blocks(part)))

    @property
    def _store(self) -> Store:
        return Store(self.folder, self.definition.hash)


def _name(part: Part, number: int) -> str:
    return f"{part}-{number:06d}.block"


def _hash(document: dict[str, Any]) -> str:
    return sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _read_definition(file: Path) -> dict[str, Any]:
    """Return the document in ``file``; raises ``InputError`` if it was changed."""
    with opened(file) as stream:
        data = stream.read()
    try:
        content = json.loads(data)
        document: dict[str, Any] = content["definition"]
        intact = content["sha256"] == _hash(document)
    except (ValueError, LookupError, TypeError, RecursionError):
        intact = False
    if not intact:
        raise InputError(file, "", "is no definition of frames as it was written")
    return document


def _first_difference(one: Any, other: Any) -> str:
    """Return the key at which two documents differ, counting from one."""
    if isinstance(one, dict) and isinstance(other, dict):
        key = next(key for key in [*one, *other] if key not in one or key not in other or one[key] != other[key])
        rest = _first_difference(one.get(key), other.get(key))
        return f"{key}.{rest}".rstrip(".").replace(".#", "#")
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        number = next(number for number, pair in enumerate(zip(one, other, strict=True)) if pair[0] != pair[1])
        return f"#{number + 1}.{_first_difference(one[number], other[number])}".rstrip(".")
    return ""
