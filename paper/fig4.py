"""Fig. 4: the objective functions B^z (Eq. 23) and B^xy (Eq. 25) over the independent friction coefficient."""

from matplotlib.figure import Figure

from tfra.paper.picture import Columns, Picture, Text, rounded
from tfra.paper.setups import Setup
from tfra.report.colours import BLACK, BLUE, ORANGE, VERMILION

PHI = 45
"""Direction of the tangential force, in degrees; the paper does not say its own."""


def fig4(setup: Setup) -> Picture:
    """Both functions over the whole sweep, the plateau of minima, and the choice."""
    result = setup.tfra(setup.stress(setup.contacts([PHI])), keep_sweep=True)
    sweep, chosen = result.sweep, int(result.sweep_index[0])
    assert sweep is not None
    plateau = sweep.plateau[0].astype(int)
    columns: Columns = {
        "mu_ind": sweep.mu[0],
        "B_z_kPa": 1e-3 * sweep.b_z[0],
        "B_xy_kPa": 1e-3 * sweep.b_xy[0],
        "plateau": plateau,
    }
    columns = rounded(columns)
    inside = sweep.mu[0][plateau == 1]
    text = Text(
        "Both functions against the independent friction coefficient, with more than one minimum of B^z; no numbers.",
        f"B^z is smallest at {len(inside)} of {len(plateau)} candidates, μ_ind from {inside[0]:.2f} to "
        f"{inside[-1]:.2f} (value {columns['B_z_kPa'].min():.3g} kPa); among them B^xy is smallest, "
        f"{columns['B_xy_kPa'][chosen]:.3g} kPa, at μ_ind = {sweep.mu[0, chosen]:.2f}.",
        "B^z is convex and piecewise linear in μ_ind, so its minima form one interval, inside which B^xy decides. "
        "Where that is an end of the interval, how exactly B^z leaves its minimum decides the result.",
    )
    title = f"Objective functions, {setup.title}, φ = {PHI}°"
    return Picture("fig4", title, columns, _draw(columns, chosen), text)


def _draw(columns: Columns, chosen: int) -> Figure:
    mu, plateau = columns["mu_ind"], columns["mu_ind"][columns["plateau"] == 1]
    figure = Figure(figsize=(6.5, 4.6), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    curves = (("B_z_kPa", "$B^z$ / kPa", BLUE), ("B_xy_kPa", "$B^{xy}$ / kPa", BLACK))
    for axes, (name, label, color) in zip(panels, curves, strict=True):
        axes.axvspan(plateau[0], plateau[-1], color=ORANGE, alpha=0.3, linewidth=0, label="minima of $B^z$")
        axes.plot(mu, columns[name], color=color)
        axes.plot(mu[chosen], columns[name][chosen], "o", color=VERMILION, markersize=7, label="chosen")
        axes.set(ylabel=label, xlim=(mu[0], mu[-1]))
        axes.legend()
    panels[-1].set_xlabel(r"independent friction coefficient $\mu_{ind}$")
    return figure
