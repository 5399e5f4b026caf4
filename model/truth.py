"""Accuracy of TFRA's friction coefficient: one sentence for the README, the demo and ``tfra estimate``."""

import json
from functools import cache
from importlib.resources import files


@cache
def medians() -> dict[str, float]:
    """Median estimated friction on random contacts, by the true one; ``make errors`` writes it."""
    by_true_mu: dict[str, float] = json.loads(files("tfra.model").joinpath("truth.json").read_text())["mu_found"]
    return by_true_mu


def sentence() -> str:
    """Accuracy of the friction coefficient, in one line."""
    low, high = medians()["0.3"], medians()["0.7"]
    return (
        "Under an elastic cover TFRA's friction coefficient is right near 0.5 only: it finds "
        f"{low:.2f} where 0.3 is true and {high:.2f} where 0.7 is true "
        "(medians of random contacts, docs/studies/errors.md)."
    )
