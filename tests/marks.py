"""Cases that only the long tests run."""

from typing import Any

import pytest

from tfra.sim.harness import bursts, flowing, random_stalls


def long(*cases: Any) -> list[Any]:
    """Each of ``cases`` as a parameter, or as several if it is a tuple, of a test that is long for it."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.long) for case in cases
    ]


_FEW = [(flowing, flowing), (random_stalls, bursts), (bursts, random_stalls)]

STALLS = [*_FEW, *long((random_stalls, random_stalls), (bursts, bursts))]
"""Stalls at the inputs and at the outputs of a block."""
