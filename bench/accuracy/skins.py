"""The table of docs/skins.md, of the held-out errors in the example's weights: ``python -m bench.accuracy.skins``."""

from collections.abc import Mapping

from bench.publish import ROOT, insert
from tfra.cli.train import condition
from tfra.codegen.config.weights import read_weights
from tfra.model.sensor import SensorArray
from tfra.train.heldout import NOISES

WINDOW = SensorArray(10, 10, 3e-3, 3e-3, 3e-3)
CONDITIONS = ("alone", "inside", "edge", "gap_4_inf", "gap_3_4", "gap_2_3", "gap_1_2", "ratio_10")


def held_out() -> Mapping[str, float]:
    """Errors on held-out frames, which the weights of the example state."""
    return read_weights(ROOT / "examples" / "fingers_32x32.weights.npz", WINDOW, window=True).held_out


def table() -> str:
    """Markdown: a row for each noise, and for each condition at 0.1 % noise."""
    found = held_out()
    lines = ["| contacts | μ, median / 95 % | F / % | φ / ° | missed | invented |", "|---|---|---|---|---|---|"]
    for name in (*(f"at_{level:g}" for level in NOISES), *CONDITIONS):
        errors = (
            f"{found[f'{key}_50_{name}']:.3g} / {found[f'{key}_95_{name}']:.3g}"
            for key in ("mu", "force_percent", "phi_deg")
        )
        shares = (
            f"{100 * found[key]:.2g} %" if (key := f"{kind}_{name}") in found else "" for kind in ("missed", "invented")
        )
        lines.append(f"| {condition(name)} | {' | '.join((*errors, *shares))} |")
    return "\n".join(lines)


if __name__ == "__main__":
    insert("skins", table(), "docs/skins.md")
