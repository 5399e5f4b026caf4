"""The page of a calibration."""

from collections.abc import Iterator, Sequence

import numpy as np

from tfra.calibrate.calibrated import Calibrated
from tfra.calibrate.compare import Errors
from tfra.calibrate.orientation import name
from tfra.calibrate.pictures import pictures
from tfra.recordings.calibration import SURE
from tfra.report.html import Section, page, paragraph
from tfra.report.table import Table, number

_TEXTS = {
    "Gains of the taxels": (
        "Left: the stress of a taxel over that which its number says. Right: its standard error, and the places of the "
        "presses. A taxel that no load has told about has the usual gain, with the spread of all gains for its error."
    ),
    "Forces that the loads show": (
        "The force that the calibrated readings of each load show, less that of the table. A slope is a sensitivity "
        "that depends on the force; a single point far off is a load in the wrong row."
    ),
    "Spread of the stress": (
        "Calibrated readings of the narrowest presses over the distance from their middle, with the layer that fits "
        "and with the thickness in CONFIG. It is the thickness that acts: soft glue counts as cover."
    ),
    "What the model leaves of each load": (
        "Readings less the fit, in per cent of the largest reading of the load. Noise is speckled. What follows the "
        "contact is a wrong shape or radius of the indenter; what stays at its taxels is a wrong gain."
    ),
}


def render(found: Calibrated, errors: Sequence[Errors], doubts: Sequence[str], advice: str) -> str:
    """The page as HTML."""
    opening = [paragraph(". ".join(line[0].upper() + line[1:] for line in lines(found)) + ".", "answer")]
    opening += [paragraph(doubt, "answer failed") for doubt in doubts]
    opening.append(paragraph(advice, "answer"))
    drawn = pictures(found)
    sections = [
        Section(f"picture-{number}", title, [paragraph(_TEXTS[title]), image])
        for number, (title, image) in enumerate(drawn.items())
    ]
    if errors:
        sections.append(Section("estimators", "What estimators make of the loads", [compared(errors).html()]))
    sections.append(Section("loads", "Loads", [_loads(found).html()]))
    return page("Calibration", opening, sections)


def lines(found: Calibrated) -> Iterator[str]:
    """What was found, for readers."""
    fit, alive = found.fit, int((~found.dead).sum())
    error = found.gain_error[found.known]
    known = f", to {100 * np.median(error):.1f} % (median)" if len(error) else ""
    yield f"{len(found.loads)} loads told the gains of {len(error)} of {alive} taxels that are alive{known}"
    yield (
        f"gains are {number(found.common)} with a spread of {100 * found.spread:.0f} %; the cover acts as one of "
        f"{1e3 * fit.thickness:.3g} mm, from {1e3 * (fit.thickness - SURE * fit.thickness_error):.3g} to "
        f"{1e3 * (fit.thickness + SURE * fit.thickness_error):.3g} mm with 95 %, Poisson's ratio {fit.poisson:.2f} "
        f"+- {SURE * fit.poisson_error:.2f}"
    )
    side = "goes on beyond the array" if fit.margin else "ends at its outer cells"
    yield f"the cover {side}; the model leaves {100 * found.misfit:.2f} % of the peaks beyond the noise"
    yield f"the array lies as {name(found.given)}{'' if found.orientation.is_sure else ', as far as is told'}"
    noise, unit = float(np.median(found.noise[~found.dead])), found.given.unit
    follow = f"drift_frames = {found.drift_frames} follows it best" if found.drift_frames else "none was seen"
    yield f"noise of a frame {number(noise)} {unit}, drift {number(found.drift)} {unit} a frame: {follow}"


def compared(errors: Sequence[Errors]) -> Table:
    """The table of ``errors``."""
    names = ("estimator", "F_z before", "after / %", "μ before", "after", "φ before", "after / °")
    rows = [
        (
            each.estimator,
            *(number(100 * value) for value in (each.force_before, each.force_after)),
            *(_known(value) for value in (each.mu_before, each.mu_after, each.phi_before, each.phi_after)),
        )
        for each in errors
    ]
    return Table("Median errors on the loads, with CONFIG as it is and after the calibration", names, rows)


def _known(value: float) -> str | None:
    return None if np.isnan(value) else number(value)


def _loads(found: Calibrated) -> Table:
    names = ("recording", "line", "F_n / N", "shown / N", "F_t / N", "x / mm", "y / mm", "radius / mm", "frames")
    rows = []
    for at, (reading, load) in enumerate(zip(found.pressed, found.loads, strict=True)):
        fit, (x, y) = found.fit, 1e3 * found.fit.place[at]
        pulled = float(np.hypot(*fit.tangential[at])) if load.tangential else None
        values = load.normal, load.normal * found.shown[at], pulled, x, y, 1e3 * fit.radius[at]
        shown = [None if value is None else number(value, 4) for value in values]
        rows.append((load.recording, load.line, *shown, f"{reading.span[0]}-{reading.span[1]}"))
    return Table("Loads as the fit sees them; places and radii are its own", names, rows)
