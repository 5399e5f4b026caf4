"""Schema of the ``[frames]`` section of a STUDY file: form only, as in :mod:`tfra.codegen.config.schema`.

examples/study_hertz.toml explains every key, study_fingers.toml those of a skin; ``recording = "frames.npz"`` takes the
place of the mixture.
"""

from typing import Annotated

import numpy as np
from pydantic import Discriminator, Field, Tag

from tfra.codegen.config.schema import Section, form
from tfra.model.arrays import Floats

MOST_FRAMES = 100_000_000
"""Of a part."""


class Range(Section):
    """``{from, to}``: anything between, uniformly; with ``log`` its logarithm is uniform."""

    low: float = Field(alias="from")
    high: float = Field(alias="to")
    log: bool = False

    def at(self, u: Floats) -> Floats:
        """Values at ``u`` in [0, 1) of the way."""
        if not self.log:
            return self.low + u * (self.high - self.low)
        return np.asarray(self.low * np.exp(u * np.log(self.high / self.low)))


Spread = Annotated[
    Annotated[float, Tag("one")]
    | Annotated[list[float], Field(min_length=1, max_length=1000), Tag("list")]
    | Annotated[Range, Tag("table")],
    Discriminator(form),
]
"""A number, a list to choose from, or a range."""

Names = Annotated[
    Annotated[str, Tag("one")] | Annotated[list[str], Field(min_length=1, max_length=1000), Tag("list")],
    Discriminator(form),
]


class ComponentSection(Section):
    """``[[frames.mixture]]``: contacts of one kind; each quantity is drawn on its own.

    Half sizes are in pitches along their axis.  A centre is a share of the footprint's possible movement on the block:
    at 0 and 1 it touches a side, at 0.5 it is in the middle.  The normal force is given, or follows from the largest
    magnitude of the frame's exact stress.  Noise (the standard deviation of every taxel) and offset (common to all
    taxels) are shares of the frame's largest stress.

    Of a skin, a frame has so many ``contacts`` of this kind, each drawn on its own, whose footprints are at least
    ``gap_pitches`` apart along an axis; the peak is then that of each contact alone.
    """

    weight: Annotated[float, Field(le=1e6)] = 1.0
    shape: Names
    half_x_pitches: Spread
    half_y_pitches: Spread
    center_x_share: Spread
    center_y_share: Spread
    force_n: Spread | None = None
    peak_kpa: Spread | None = None
    mu: Spread
    phi_deg: Spread
    noise_share_of_peak: Spread = 0.0
    offset_share_of_peak: Spread = 0.0
    contacts: Spread | None = None
    gap_pitches: Annotated[float, Field(ge=0, le=1e4)] | None = None


Count = Annotated[int, Field(ge=0, le=MOST_FRAMES)]


class FramesSection(Section):
    """``[frames]``: number of frames of each part, and their source."""

    train: Count
    held_out: Count
    seed: Annotated[int, Field(ge=0)] = 0
    recording: str | None = None
    mixture: list[ComponentSection] = Field(default_factory=list)
