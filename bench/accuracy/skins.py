"""The tables of docs/skins.md: held-out errors in the example's weights, other skins, and what the uncertainty tells.

``python -m bench.accuracy.skins`` measures on a larger skin and by finite elements, which takes ten minutes, and writes
``bench/results/skins.json``.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bench.publish import ROOT, insert, store
from tfra.cli.train import condition
from tfra.codegen.config.weights import Trained, read_weights
from tfra.model.arrays import Bools, Floats
from tfra.model.choices import Search
from tfra.model.cover.contact import Contact, Contacts, ContactShape
from tfra.model.cover.fem import Mesh, fem_frames
from tfra.model.learned.network import Network
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra
from tfra.report.table import Table
from tfra.train.heldout import NOISES, QUIET
from tfra.train.skins import CONTACTS, COUNT, GAPS, SEED, Crowd, Seen, errors_of

WINDOW = SensorArray(10, 10, 3e-3, 3e-3, 3e-3)
CONDITIONS = ("alone", "inside", "edge", "gap_4_inf", "gap_3_4", "gap_2_3", "gap_1_2", "ratio_10")
MEASURES = ("mu", "force_percent", "phi_deg")
HEADS = ["contacts", "μ, median / 95 %", "F / %", "φ / °", "missed", "invented"]

WRONG = 12.0
"""Error of the force in percent from which the uncertainty is to tell."""

FEM_SIDES, FEM_FRAMES, FEM_MESH = 2.0, 8, Mesh(size=0.45e-3)
"""The skin in finite elements: windows a side, and frames of two contacts."""


def trained() -> Trained:
    """The weights of the example, and what they state."""
    return read_weights(ROOT / "examples" / "fingers_32x32.weights.npz", WINDOW, window=True)


def held_out() -> Mapping[str, float]:
    """Errors on held-out frames, which the weights of the example state."""
    return trained().held_out


def finite_elements(sensor: SensorArray, contacts: Contacts) -> Floats:
    """Stress ``(k, rows, columns)`` in Pa of ``contacts`` on a block of the sensor's size."""
    force = contacts.force
    columns = (contacts.shape.tolist(), *contacts.center.T, *contacts.half.T, force[:, 2])
    mu, phi = np.hypot(force[:, 0], force[:, 1]) / -force[:, 2], np.arctan2(force[:, 1], force[:, 0])
    every = [Contact(ContactShape(shape), *map(float, rest)) for shape, *rest in zip(*columns, mu, phi, strict=True)]
    return fem_frames(sensor, every, FEM_MESH)


def by_tfra(n: Floats) -> Floats:
    """Outputs of TFRA for windows of normal forces ``n (k, m)`` in N: resultants, and no uncertainty."""
    stress = n.reshape(-1, WINDOW.rows, WINDOW.columns) / WINDOW.taxel_area
    found = Tfra(WINDOW, Search().steps)(stress)
    return np.concatenate([found.resultant, np.zeros((len(n), 1))], axis=1)


def measured() -> dict[str, Any]:
    """Errors on other skins, and how often the uncertainty tells of contacts whose force is off."""
    of = trained()
    network = Network(WINDOW, of.weights)
    counts = np.repeat(np.arange(1, CONTACTS + 1), COUNT)
    usual = Crowd.of(WINDOW, counts, SEED)
    quiet, close = usual.see(WINDOW, network, QUIET), Crowd.of(WINDOW, counts, SEED + 1, GAPS[0])
    near = close.see(WINDOW, network, QUIET)
    told = {
        "of a single contact": _part(quiet, quiet.gap == np.inf),
        "all": quiet,
        "with a gap of 2 to 3 pitches": _part(quiet, quiet.gap < 3),
        "with a gap of 1 to 2 pitches": _part(near, near.gap < 2),
        "with forces up to 1:10": Crowd.of(WINDOW, counts, SEED + 2, ratio=10.0).see(WINDOW, network, QUIET),
        "at 1 % noise": usual.see(WINDOW, network, NOISES[-1]),
    }
    large = Crowd.of(WINDOW, counts, SEED + 3, sides=6.4).see(WINDOW, network, QUIET)
    paper = usual.see(WINDOW, by_tfra, QUIET)
    two = np.full(FEM_FRAMES, 2)
    solid = Crowd.of(WINDOW, two, SEED + 4, sides=FEM_SIDES, simulate=finite_elements).see(WINDOW, network, QUIET)
    same = Crowd.of(WINDOW, two, SEED + 4, sides=FEM_SIDES).see(WINDOW, network, QUIET)
    skins = {
        "64 × 64 taxels": large,
        "32 × 32 taxels, TFRA, of a single contact": _part(paper, paper.gap == np.inf),
        "32 × 32 taxels, TFRA": paper,
        f"20 × 20 taxels, {len(solid.force)} contacts by finite elements": solid,
        "the same contacts by the exact series": same,
    }
    return {
        "told": {name: _told(seen, of.threshold) for name, seen in told.items()},
        "skins": {
            name: errors_of(seen, "all")
            | {f"{kind}_all": share for kind in ("missed", "invented") if (share := getattr(seen, kind)) >= 0}
            for name, seen in skins.items()
        },
    }


def _part(seen: Seen, which: Bools) -> Seen:
    """Some of the contacts, of which no shares are known."""
    return Seen(seen.force[which], seen.output[which], seen.gap[which], seen.edge[which], np.nan, np.nan)


def _told(seen: Seen, threshold: float) -> dict[str, float]:
    """Shares of contacts that are off by more than ``WRONG``, that are implausible, and of these in those."""
    off = np.linalg.norm(seen.output[:, :3] - seen.force, axis=1) > WRONG / 100 * np.linalg.norm(seen.force, axis=1)
    normal = seen.output[:, 2]
    unsure = (normal >= 0) | (seen.output[:, 3] > threshold * np.abs(normal))
    shares = {"wrong": off.mean(), "implausible": unsure.mean()}
    shares |= {"of_wrong": unsure[off].mean()} if off.any() else {}
    return {name: float(share) for name, share in shares.items()}


def errors(found: Mapping[str, float], name: str) -> list[str]:
    """The cells of a row of errors."""
    keys = (f"{kind}_{name}" for kind in ("missed", "invented"))
    shares = (f"{100 * found[key]:.2g} %" if key in found else "" for key in keys)
    return [*(f"{found[f'{key}_50_{name}']:.3g} / {found[f'{key}_95_{name}']:.3g}" for key in MEASURES), *shares]


def table() -> str:
    """Markdown: a row for each noise, and for each condition at 0.1 % noise."""
    found = held_out()
    names = (*(f"at_{level:g}" for level in NOISES), *CONDITIONS)
    return _markdown(HEADS, [[condition(name), *errors(found, name)] for name in names])


def others(record: Mapping[str, Any]) -> str:
    """Markdown: errors on other skins."""
    return _markdown(HEADS, [[name, *errors(found, "all")] for name, found in record["skins"].items()])


def told(record: Mapping[str, Any]) -> str:
    """Markdown: what the uncertainty tells."""
    heads = ["contacts", f"force off by more than {WRONG:g} %", "implausible", "of those that are off"]
    cells = ("wrong", "implausible", "of_wrong")
    rows = [
        [name, *(f"{100 * found[key]:.0f} %" if key in found else "–" for key in cells)]
        for name, found in record["told"].items()
    ]
    return _markdown(heads, rows)


def _markdown(heads: list[str], rows: list[list[str]]) -> str:
    return Table("", heads, rows, range(len(heads))).markdown()


def main() -> None:
    """Measure and write everything."""
    record = measured()
    insert("skins", table(), "docs/skins.md")
    store("skins", record)
    insert("skins others", others(record), "docs/skins.md")
    insert("skins told", told(record), "docs/skins.md")


if __name__ == "__main__":
    main()
