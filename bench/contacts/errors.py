"""Sources of TFRA's error: one influence at a time, on random contacts and on the paper's two.

``python -m bench.contacts.errors [--contacts N]`` writes ``bench/results/errors.json``, the figure beside it and the
tables of friction in docs/studies/errors.md; :mod:`bench.contacts.truth` updates the README.  Errors are those of
Eqs. 33-35 of doi:10.1016/j.mechatronics.2023.103070.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.accuracy.loads import peak
from bench.contacts import truth
from bench.contacts.half_space import half_space
from bench.publish import ROOT, insert, store
from tfra.codegen.config.read import load
from tfra.model.arrays import Floats
from tfra.model.boussinesq import operators
from tfra.model.cover.contact import Contacts, taxel_forces
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import random_contacts
from tfra.model.metrics import error_force, turn_deg
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Tfra, friction

PAGE = "docs/studies/errors.md"
SEED = 2024
EXAMPLES = {"ellipse": "hertz_40x20", "rectangle": "rectangle_40x40"}
MEASURES = {"force": "#D55E00", "mu": "#0072B2", "phi": "#009E73"}  # colours of Okabe and Ito
NAMES = {"force": "F", "mu": "μ", "phi": "φ"}


@dataclass(frozen=True)
class Group:
    """Contacts on one sensor."""

    sensor: SensorArray
    contacts: Contacts

    @property
    def pitch(self) -> Floats:
        """Both pitches ``(2,)``, m."""
        return np.array([self.sensor.pitch_x, self.sensor.pitch_y])

    @property
    def middle(self) -> Floats:
        """Middle of the array ``(2,)``, m."""
        return self.pitch * (self.sensor.columns - 1, self.sensor.rows - 1) / 2

    def changed(self, **fields: Floats) -> "Group":
        """The same contacts with other fields of :class:`Contacts`, whose shapes they broadcast to."""
        arrays: dict[str, Any] = {
            name: np.broadcast_to(value, getattr(self.contacts, name).shape) for name, value in fields.items()
        }
        return replace(self, contacts=replace(self.contacts, **arrays))


@dataclass(frozen=True)
class Scene:
    """Frames ``(n, rows, columns)`` in Pa, the true resultants ``(n, 3)`` in N, and the steps of the search."""

    sensor: SensorArray
    stress: Floats
    forces: Floats
    steps: int = 100


Scenes = Iterator[tuple[str, Scene]]


def groups(count: int) -> dict[str, Group]:
    """Random contacts on the 40 x 40 mm sensor, and the examples' contacts in 24 directions.

    Of ``count`` drawn ones those are left out that TFRA flags, nearly always because no taxel is under traction.
    """
    projects = {name: load(ROOT / "examples" / f"{example}.toml") for name, example in EXAMPLES.items()}
    paper = {name: Group(project.design.sensor, Contacts.of(project.contacts)) for name, project in projects.items()}
    sensor = paper["rectangle"].sensor
    drawn = Contacts.of(random_contacts(sensor, count, np.random.default_rng(SEED)))
    swept = Tfra(sensor)(frames(sensor, drawn)).status == 0
    return {"random": Group(sensor, Contacts(**{key: array[swept] for key, array in vars(drawn).items()}))} | paper


def scene(group: Group, steps: int = 100) -> Scene:
    """The group on an elastic layer, stress at the taxels' centres."""
    return Scene(group.sensor, frames(group.sensor, group.contacts), group.contacts.force, steps)


def kernels(group: Group) -> Scenes:
    """Scenes from TFRA's assumptions to a sensor's conditions."""
    sensor, contacts, forces = group.sensor, group.contacts, group.contacts.force
    ideal = taxel_forces(sensor, contacts).reshape(len(contacts), -1) @ operators(sensor).a.T  # Eq. 3
    yield "forces at taxels", Scene(sensor, ideal.reshape(-1, sensor.rows, sensor.columns), forces)
    yield "half-space", Scene(sensor, half_space(sensor, contacts), forces)
    yield "layer", scene(group)
    yield "layer, areas", Scene(sensor, frames(sensor, contacts, "area"), forces)


def resolutions(group: Group) -> Scenes:
    """Arrays of 5 x 5 to 20 x 20 taxels over the same surface."""
    sensor = group.sensor
    for side in (5, 7, 10, 14, 20):
        finer = Group(
            SensorArray(side, side, sensor.size_x / side, sensor.size_y / side, sensor.thickness), group.contacts
        )
        yield f"{side}×{side}", scene(finer.changed(center=group.contacts.center + (group.pitch - finer.pitch) / 2))


def noises(group: Group) -> Scenes:
    """Normal noise on every taxel, its standard deviation in percent of the frame's peak."""
    exact, rng = scene(group), np.random.default_rng(SEED)
    for percent in (0, 0.1, 0.3, 1, 3):
        noise = percent / 100 * peak(exact.stress) * rng.normal(size=exact.stress.shape)
        yield f"{percent:g} %", replace(exact, stress=exact.stress + noise)


def converters(group: Group) -> Scenes:
    """Rounded to signed codes; full scale is 105 % of the group's largest stress."""
    exact = scene(group)
    full = 1.05 * np.abs(exact.stress).max()
    for bits in (8, 10, 12, 14, 16):
        lsb = full / 2 ** (bits - 1)
        yield f"{bits}", replace(exact, stress=np.rint(exact.stress / lsb) * lsb)


def frictions(group: Group, layer: bool) -> Scenes:
    """Every contact with one friction coefficient, on the layer or on a half-space."""
    force = group.contacts.force
    for mu in (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9):
        tangential = force[:, :2] * (mu / friction(force))[:, None]
        same = group.changed(force=np.concatenate([tangential, force[:, 2:]], axis=1))
        stress = (frames if layer else half_space)(same.sensor, same.contacts)
        yield f"{mu:g}", Scene(same.sensor, stress, same.contacts.force)


def sizes(group: Group) -> Scenes:
    """Half sides from a quarter to four pitches, centres within half a pitch of the middle; the paper's stay."""
    rng, count = np.random.default_rng(SEED), len(group.contacts)
    spread = 0.0 if len(np.unique(group.contacts.center, axis=0)) == 1 else 0.5
    centres = group.middle + rng.uniform(-spread, spread, (count, 2)) * group.pitch
    for size in (0.25, 0.5, 0.75, 1, 1.5, 2, 3, 3.5):
        yield f"{size:g}", scene(group.changed(half=size * group.pitch, center=centres))


def centres(group: Group) -> Scenes:
    """Moved off the middle by up to three pitches in a random direction; half sizes at most two pitches."""
    rng = np.random.default_rng(SEED)
    angle = rng.uniform(0, 2 * np.pi, len(group.contacts))
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1) * group.pitch
    small = group.changed(half=np.minimum(group.contacts.half, 2 * group.pitch))
    for distance in (0, 0.25, 0.5, 1, 2, 3):
        yield f"{distance:g}", scene(small.changed(center=group.middle + distance * way))


def pairs(group: Group, turned: bool) -> Scenes:
    """Two contacts at once, apart along x, half sizes at most a pitch; they share the force by 20 to 80 %.

    ``turned`` gives the second one's tangential force a direction of its own.
    """
    rng, count = np.random.default_rng(SEED), len(group.contacts)
    share = rng.uniform(0.2, 0.8, count)
    turn = rng.uniform(0, 2 * np.pi, count) * turned
    small = group.changed(half=np.minimum(group.contacts.half, group.pitch))
    x, y, z = group.contacts.force.T
    other = np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, z])
    for distance in (0, 2, 3, 4, 5, 6):
        apart = np.array([distance / 2, 0]) * group.pitch
        one = scene(small.changed(center=group.middle - apart, force=(share * [x, y, z]).T))
        two = scene(small.changed(center=group.middle + apart, force=((1 - share) * other).T))
        yield f"{distance}", replace(one, stress=one.stress + two.stress, forces=one.forces + two.forces)


def searches(group: Group) -> Scenes:
    """Steps of the search for the friction coefficient."""
    exact = scene(group)
    for steps in (10, 20, 50, 100, 200, 500, 1000):
        yield f"{1 / steps:g}", replace(exact, steps=steps)


STUDIES: dict[str, tuple[str, Callable[[Group], Scenes]]] = {
    "kernel": ("stress from", kernels),
    "resolution": ("taxels over the same surface", resolutions),
    "noise": ("noise, share of the peak", noises),
    "converter": ("bits of the converter", converters),
    "friction": ("μ of the contact", lambda group: frictions(group, True)),
    "half-space": ("μ of the contact, half-space", lambda group: frictions(group, False)),
    "size": ("half size / pitch", sizes),
    "centre": ("centre off the middle / pitch", centres),
    "same": ("two contacts, same direction: distance / pitch", lambda group: pairs(group, False)),
    "turned": ("two contacts, random directions: distance / pitch", lambda group: pairs(group, True)),
    "search": ("step Δ of the search", searches),
}
"""Influences: what their settings are, and their scenes."""


def errors(forces: Floats, found: Result) -> dict[str, Floats]:
    """Eqs. 33-35 in percent, ``(n,)`` each: the worst component of the force, mu, phi."""
    tangential = np.hypot(forces[:, 0], forces[:, 1])
    phi = np.degrees(np.arctan2(forces[:, 1], forces[:, 0]))
    return {
        "force": error_force(forces, found.resultant).max(axis=1),
        "mu": 100.0 * np.abs(tangential / np.abs(forces[:, 2]) - found.mu),
        "phi": turn_deg(phi, found.phi_deg) / 3.6,
    }


def measure(case: Scene) -> dict[str, Any]:
    """Median and 95th percentile of the errors in percent, the median of found over true modulus of the resultant,
    how many frames are flagged, and 5th, 50th and 95th percentile of mu in the others."""
    found = Tfra(case.sensor, case.steps)(case.stress)
    spread = {key: np.percentile(values, (50, 95)).round(3) for key, values in errors(case.forces, found).items()}
    moduli = [np.linalg.norm(forces, axis=1) for forces in (found.resultant, case.forces)]
    swept = found.mu[found.status == 0]
    return {key: {"median": float(a), "p95": float(b)} for key, (a, b) in spread.items()} | {
        "modulus": round(float(np.median(moduli[0] / moduli[1])), 3),
        "flagged": int((found.status != 0).sum()),
        "frames": len(found.mu),
        "mu_found": np.percentile(swept, (5, 50, 95)).round(3).tolist() if len(swept) else None,
    }


def friction_table(results: dict[str, dict[str, Any]]) -> str:
    """Markdown: the friction coefficient that is found in frames without a flag, and the share of the others."""
    lines = ["| true μ |" + "".join(f" {who}: μ found | flagged |" for who in results)]
    lines.append("|---:|" + "---:|---:|" * len(results))
    for setting in next(iter(results.values())):
        cells = []
        for row in (rows[setting] for rows in results.values()):
            found = row["mu_found"]
            cells.append("–" if found is None else "{1:.2f} ({0:.2f} to {2:.2f})".format(*found))
            cells.append(f"{row['flagged'] / row['frames']:.0%}")
        lines.append(f"| {setting} | {' | '.join(cells)} |")
    return "\n".join(lines)


SHOWN = (0.3, 100.0)
"""Errors from, to, in percent."""


def plot(results: dict[str, dict[str, Any]]) -> None:
    """Write ``bench/results/errors.svg``: a panel each study, of the random contacts."""
    mpl.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "tfra"})
    figure = Figure(figsize=(15, 10), layout="constrained")
    *panels, corner = figure.subplots(3, 4, sharey=True).flat
    for axes, (name, result) in zip(panels, results.items(), strict=True):
        rows = result["random"]
        for (key, color), marker in zip(MEASURES.items(), "os^", strict=True):
            for part, line, text in (("median", "-", ", median"), ("p95", ":", ", 95th percentile")):
                values = [row[key][part] for row in rows.values()]
                axes.plot(list(rows), values, line + marker, color=color, ms=4, label=NAMES[key] + text)
                _mark_outside(axes, values, color)
        axes.set(xlabel=STUDIES[name][0], yscale="log", ylim=SHOWN)
        axes.yaxis.set_major_formatter("{x:g}")
        axes.tick_params(labelleft=True)
        if name == "kernel":
            axes.set_xticks(range(len(rows)), [text.replace(" ", "\n") for text in rows], fontsize=8)
    figure.supylabel("error of random contacts (Eqs. 33–35) / %", fontsize=10)
    corner.set_axis_off()
    corner.legend(*axes.get_legend_handles_labels(), loc="center", fontsize=10)
    figure.savefig(ROOT / "bench" / "results" / "errors.svg", metadata={"Date": None})


def _mark_outside(axes: Axes, values: Sequence[float], color: str) -> None:
    """An arrow at the edge and the value, for each that lies above what is shown."""
    for place, value in enumerate(values):
        if value > SHOWN[1]:
            axes.annotate(
                f"{value:.0f} %", (place, SHOWN[1]), xytext=(8, -24), textcoords="offset points", color=color,
                arrowprops={"arrowstyle": "->", "color": color}, annotation_clip=False,
            )  # fmt: skip


def main() -> None:
    """Measure, write the JSON, the figure and the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=1000, help="random contacts to draw")
    count = parser.parse_args().contacts
    everyone = groups(count)
    results = {
        name: {who: {label: measure(case) for label, case in scenes(group)} for who, group in everyone.items()}
        for name, (_, scenes) in STUDIES.items()
    }
    store("errors", {"drawn": count, "contacts": len(everyone["random"].contacts), "seed": SEED, "results": results})
    for name in ("friction", "half-space"):
        insert(f"{name} found", friction_table(results[name]), PAGE)
    truth.main()
    plot(results)


if __name__ == "__main__":
    main()
