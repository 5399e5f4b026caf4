"""Accuracy of TFRA's friction coefficient, from the study of errors into the pages and the package.

``python -m bench.contacts.truth`` writes ``model/truth.json``, the table in docs/measured.md and a sentence of
README.md from ``bench/results/errors.json``; ``bench.contacts.errors`` also does this after its measurement.
"""

import json
import textwrap
from typing import Any

from bench.publish import ROOT, insert, stored
from tfra.model import truth

TOLD = ("0.3", "0.5", "0.7")
"""True friction coefficients for which the package has the estimated ones."""


def rows() -> dict[str, Any]:
    """Results of the random contacts, by their true friction coefficient."""
    friction: dict[str, Any] = stored("errors")["results"]["friction"]["random"]
    return friction


def medians(friction: dict[str, Any]) -> dict[str, Any]:
    """The content of ``model/truth.json``."""
    return {"source": "bench/results/errors.json", "mu_found": {mu: friction[mu]["mu_found"][1] for mu in TOLD}}


def table(friction: dict[str, Any]) -> str:
    """Markdown with a column for each true friction: the estimate, its error, and frames without one."""
    flagged = (f"{row['flagged'] / row['frames']:.0%}" for row in friction.values())
    lines = {
        "true μ": friction,
        "μ found, median (5–95 %)": map(_found, friction.values()),
        "φ off, median, in degrees": map(_phi, friction.values()),
        "force found over true modulus, median": (f"{row['modulus']:.2f}" for row in friction.values()),
        "frames with a status bit, nearly all `COMPRESSION_ONLY`": flagged,
    }
    head, *rest = (f"| {name} | {' | '.join(cells)} |" for name, cells in lines.items())
    return "\n".join([head, "|---|" + "---:|" * len(friction), *rest])


def _found(row: dict[str, Any]) -> str:
    percentiles = row["mu_found"]
    return "–" if percentiles is None else "{1:.2f} ({0:.2f}–{2:.2f})".format(*percentiles)


def _phi(row: dict[str, Any]) -> str:
    """Degrees of a percentage of a full turn; none where most frames are flagged, since these have no direction."""
    return "–" if 2 * row["flagged"] > row["frames"] else f"{3.6 * row['phi']['median']:.0f}"


def main() -> None:
    """Write all of them."""
    friction = rows()
    (ROOT / "model" / "truth.json").write_text(json.dumps(medians(friction), indent=1) + "\n")
    truth.medians.cache_clear()
    insert("right", table(friction))
    insert("truth", textwrap.fill(f"- {truth.sentence()}", 120, subsequent_indent="  "), "README.md")


if __name__ == "__main__":
    main()
