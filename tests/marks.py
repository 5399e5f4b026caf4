"""Cases that only the long tests run."""

from __future__ import annotations

from typing import Any

import pytest


def long(*cases: Any) -> list[Any]:
    """Each of ``cases`` as a parameter, or as several if it is a tuple, of a test that is long for it."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.long) for case in cases
    ]
