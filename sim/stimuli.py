"""Frames for verification: simulated contacts, random codes, and the corners of the input space."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.cover.scenes import directed_codes, known_contacts, wild_codes
from tfra.model.fixed.design import Design

CONTACTS = 60
"""Simulated contacts when no frames are given."""

REFERENCES = ("resultant_ref", "mu_ref", "phi_ref_deg")
"""Keys of a frames file with the ground truth of the contacts: N, 1, degrees."""


@dataclass(frozen=True)
class Stimuli:
    """Converter codes ``(n, rows, columns)`` with the kind of each frame; true values are NaN where unknown."""

    codes: Ints
    kinds: npt.NDArray[np.str_]
    resultant: Floats
    """``(n, 3)`` N."""
    mu: Floats
    phi_deg: Floats

    @classmethod
    def of(cls, codes: Ints, kind: str, references: Mapping[str, npt.ArrayLike] | None = None) -> "Stimuli":
        """Frames of one kind, with the references of a frames file if there are any."""
        n, truth = len(codes), []
        for key, shape in zip(REFERENCES, ((n, 3), (n,), (n,)), strict=True):
            value = np.array((references or {}).get(key, np.full(shape, np.nan)), dtype=np.float64)
            if value.shape != shape:
                raise ValueError(f"{key}: shape {shape} is needed, got {value.shape}")
            truth.append(value)
        return cls(codes, np.full(n, kind), *truth)

    def __add__(self, other: "Stimuli") -> "Stimuli":
        pairs = ((getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__)
        return Stimuli(*(np.concatenate(pair) for pair in pairs))

    @property
    def known(self) -> Bools:
        """Whether the true values of each frame are known."""
        return np.asarray(np.isfinite(self.resultant).all(axis=1))

    def __getitem__(self, part: slice | Bools) -> "Stimuli":
        return Stimuli(*(getattr(self, name)[part] for name in self.__dataclass_fields__))


def mixture(design: Design, seed: int, random: int) -> Stimuli:
    """Return simulated contacts, ``random`` random frames and every directed one."""
    rng = np.random.default_rng(seed)
    known = known_contacts(design, CONTACTS, rng)
    truth = dict(zip(REFERENCES, (known.resultant, known.mu, known.phi_deg), strict=True))
    contacts, wild = Stimuli.of(known.codes, "contact", truth), Stimuli.of(wild_codes(design, random, rng), "random")
    return contacts + wild + Stimuli.of(directed_codes(design), "directed")
