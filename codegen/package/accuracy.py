"""Errors of the bit-accurate model on simulated contacts, for the datasheet."""

from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Bools
from tfra.model.converter import quantise
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import crowds, known_contacts
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.metrics import Contact, Some, errors
from tfra.model.skin.matching import matched, seen_at
from tfra.model.skin.skin import Skin
from tfra.model.skin.windows import PLACE_FRACTION
from tfra.report.table import Table

CONTACTS = 60
SEED = 1
"""Contacts of random shape, place, friction and direction, at 5 to 95 % of full scale, without noise."""

_TOGETHER, _ROOM = 4, 100
"""Most contacts of a skin's frame, and taxels for each."""

_ERRORS = {"phi_deg": "φ / °", "mu_abs": "μ", "force_percent_of_resultant": "F / % of |F|"}


def accuracy(array: Design | Skin) -> tuple[int, Table]:
    """How many contacts have a direction, and the errors of the bit-accurate model on these.

    Against double precision, and against the forces that were simulated; of a skin, of the contacts that were found,
    and how many were not.
    """
    known = _on_skin(array) if isinstance(array, Skin) else _alone(array)
    against = {"double precision, same codes": known.exact, "the simulated contact": known.truth}
    rows = []
    for reference, other in against.items():
        by_name = errors(other, known.fixed)
        for key, name in _ERRORS.items():
            values = by_name[key][known.clear]
            median, high = np.percentile(values, (50, 95)) if len(values) else (0.0, 0.0)
            rows.append((reference, name, f"{median:.3g}", f"{high:.3g}"))
    if isinstance(array, Skin):
        rows += [("the simulated contact", name, f"{count}", "") for name, count in known.unpaired.items()]
    head = ("against", "error of", "median", "95th percentile")
    return int(known.clear.sum()), Table("Accuracy", head, rows, (0, 1))


class _Known(NamedTuple):
    """The same contacts as they are, and as both models find them; ``clear``: those with a direction.

    ``unpaired``: how many there are only in the frames, or only in the results.
    """

    truth: Contact
    exact: Contact
    fixed: Contact
    clear: Bools
    unpaired: dict[str, int]


def _alone(design: Design) -> _Known:
    """A contact a frame."""
    truth = known_contacts(design, CONTACTS, SEED)
    exact = design.float_model(truth.codes * design.adc.lsb)
    return _Known(truth, exact, decode(design, design.model(truth.codes).words), exact.status == 0, {})


def _on_skin(skin: Skin) -> _Known:
    """As many contacts a frame as there is room for, two pitches apart; pairs of those there and those found."""
    rng, sensor = np.random.default_rng(SEED), skin.sensor
    together = int(np.clip(sensor.taxels // _ROOM, 1, min(_TOGETHER, skin.choices.most)))
    contacts, frame = crowds(sensor, np.full(CONTACTS // together, together), rng)
    stress = np.zeros((frame[-1] + 1, sensor.rows, sensor.columns))
    np.add.at(stress, frame, frames(sensor, contacts))
    peak = np.abs(stress).max(axis=(1, 2))
    scale = rng.uniform(0.05, 0.95, len(stress)) * skin.adc.full_scale / peak
    found, cut = skin.find(quantise(skin, stress * scale[:, None, None]))
    places = np.stack([found.column, found.row], axis=1) / (1 << PLACE_FRACTION)
    there, seen = matched((frame, found.frame), (seen_at(contacts.center, contacts.force, sensor), places))
    x, y, z = (contacts.force * scale[frame, None])[there].T
    truth = Some(np.stack([x, y, z], axis=1), np.hypot(x, y) / np.abs(z), np.degrees(np.arctan2(y, x)))
    exact = skin.window.float_model(cut * skin.adc.lsb)
    fixed = decode(skin.window, skin.window.model(cut).words)
    unpaired = {"contacts missed": len(frame) - len(there), "contacts invented": len(found.frame) - len(seen)}
    return _Known(truth, Some.of(exact, seen), Some.of(fixed, seen), exact.status[seen] == 0, unpaired)
