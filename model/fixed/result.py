"""The result of a bit-accurate model."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Ints


@dataclass(frozen=True)
class FixedResult:
    """``words (n, frame_words)`` as the core sends them."""

    words: Ints
    parts: tuple[Mapping[str, Ints], ...]

    @property
    def stages(self) -> dict[str, Ints]:
        """What flows between blocks, by name: the first axis is the frame, then come transfers in their order."""
        return {name: np.concatenate([part[name] for part in self.parts]) for name in self.parts[0]}
