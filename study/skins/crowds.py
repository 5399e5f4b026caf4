"""Frames of a skin: several contacts of a declared mixture, drawn one by one, none nearer to another than a gap.

Frame i of a part depends only on the definition, the part and i, as in :mod:`tfra.study.frames.mixture`.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import polars as pl

from tfra.codegen.config.cover import LayerSpec
from tfra.model.arrays import Floats, Ints
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import gaps, nearest
from tfra.model.skin.skin import Skin
from tfra.study.frames.block import Block, Part, Stream, generator, with_noise
from tfra.study.frames.frameset import Definition, blame
from tfra.study.frames.mixture import LIMITS, Mixture, as_list, choose, ends, scale, truth
from tfra.study.frames.schema import ComponentSection, FramesSection, Range

BLOCK = 64
"""Frames of a block."""

TRIES = 512
"""Contacts that are drawn for a frame, until so many of them as it has are apart."""

_COMMON = ("component", "noise_share_of_peak", "offset_share_of_peak")
"""What all contacts of a frame share, in the table of the truth."""

_COMMON_DRAWS = [0, *(2 + list(LIMITS).index(key) for key in _COMMON[1:])]
"""The same as columns of the draws, which begin with component and shape."""


@dataclass(frozen=True)
class Crowds(Mixture):
    """Frames of several contacts, of which ``most`` can be found."""

    most: int

    def _require_number(self, component: ComponentSection) -> None:
        for value in ends(1 if component.contacts is None else component.contacts):
            if value != int(value) or not 1 <= value <= self.most:
                reason = f"whole numbers of 1 to {self.most} are needed, most of [contacts] in CONFIG, got {value:g}"
                raise ValueError(f"contacts: {reason}")
        if isinstance(component.contacts, Range) and (component.contacts.log or not _rises(component.contacts)):
            raise ValueError("contacts: a range upwards without log is needed")

    def block(self, part: Part, number: int, count: int) -> Block:
        """Return the first ``count`` frames of block ``number``; the truth has lists of contacts."""
        draws, noise = (generator(self.seed, part, number, stream) for stream in Stream)
        each = [self._frame(draws) for _ in range(count)]
        frame = np.repeat(np.arange(count), [len(u) for u in each])
        component, shape, values = self._draw(np.concatenate(each))
        contacts = self._contacts(shape, values)
        alone = frames(self.sensor, contacts, self.layer.sampling, self.layer.poisson)
        factor = scale(alone, values["peak_kpa"])
        contacts = replace(contacts, force=contacts.force * factor[:, None])
        together = np.zeros((count, self.sensor.rows, self.sensor.columns))
        np.add.at(together, frame, alone * factor[:, None, None])
        stress = together.astype(np.float32)
        table = truth(component, contacts, values).with_columns(
            frame=frame, gap_pitches=nearest(contacts, frame, self.sensor)
        )
        of_frames = table.group_by("frame", maintain_order=True).agg(pl.col(_COMMON).first(), pl.exclude(_COMMON))
        spread, offset = (of_frames[key].to_numpy() for key in _COMMON[1:])
        noisy = with_noise(stress, spread, offset, noise.standard_normal(stress.shape))
        return Block(number * BLOCK, stress, noisy, np.full_like(stress, np.nan), of_frames.drop("frame"))

    def _frame(self, rng: np.random.Generator) -> Floats:
        """The draws of a frame's contacts, a row each."""
        u = rng.random((TRIES, 2 + len(LIMITS)))
        u[:, _COMMON_DRAWS] = u[0, _COMMON_DRAWS]
        component, shape, values = self._draw(u)
        kind = self.components[component[0]]
        wanted = _number(kind, rng.random())
        apart = self._apart(self._contacts(shape, values), wanted, kind.gap_pitches or 0.0)
        if len(apart) < wanted:
            room = f"{wanted} contacts with a gap of {kind.gap_pitches or 0:g} pitches find no room, {len(apart)} do"
            raise ValueError(f"mixture#{component[0] + 1}.contacts: {room}")
        return u[apart]

    def _apart(self, contacts: Contacts, wanted: int, gap: float) -> list[int]:
        """The first contacts, ``wanted`` or fewer, that are apart from all before them."""
        pitch = np.array([self.sensor.pitch_x, self.sensor.pitch_y])
        kept: list[int] = []
        for number in range(len(contacts)):
            if len(kept) == wanted:
                break
            own = contacts.center[number], contacts.half[number]
            if (gaps(*own, contacts.center[kept], contacts.half[kept], pitch) >= gap).all():
                kept.append(number)
        return kept


def _rises(given: Range) -> bool:
    return given.low < given.high


def _number(kind: ComponentSection, u: float) -> int:
    """How many contacts a frame has, from ``u`` in [0, 1)."""
    given = 1 if kind.contacts is None else kind.contacts
    if isinstance(given, Range):
        return int(given.low + u * (given.high + 1 - given.low))
    return int(choose(as_list(given), np.array([u]))[0])


def definition(file: Path, skin: Skin, layer: LayerSpec, section: FramesSection) -> Definition:
    """The definition that the STUDY ``file`` has in ``[frames]``; raises ``InputError`` that names the key."""
    with blame(file, "frames"):
        if section.recording is not None:
            raise ValueError("recording: of a skin the contacts of every frame must be known: a mixture is needed")
        if not section.mixture:
            raise ValueError("mixture: is missing")
        if not section.train:
            raise ValueError("train: at least one is needed, got none")
        source = Crowds(skin.sensor, layer, section.mixture, section.seed, skin.choices.most)
        if section.held_out:
            source.require_disjoint()
        return Definition(skin.sensor, layer, section, source, BLOCK)


def contacts_of(block: Block) -> tuple[pl.DataFrame, Ints]:
    """All contacts of a block, a row each, and the number of the frame of each, ``(k,)``, within the block."""
    table = block.truth.with_row_index("frame")
    lists = [name for name, kind in table.schema.items() if isinstance(kind, pl.List)]
    flat = table.explode(lists)
    return flat, flat["frame"].to_numpy().astype(np.int64)
