"""Accuracy of a core on simulated contacts: against double precision, and against the forces that were simulated."""

import numpy as np

from tfra.model.cover.scenes import known_contacts
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.metrics import errors

CONTACTS, SEED = 60, 1
"""Contacts of random shape, place, friction and direction, at 5 to 95 % of full scale, without noise."""

_ERRORS = {"phi_deg": "φ / °", "mu_abs": "μ", "force_percent_of_resultant": "F / % of |F|"}

Errors = dict[tuple[str, str], tuple[float, float]]
"""Median and 95th percentile, by the reference and the name of an error."""


def accuracy(design: Design) -> tuple[int, Errors]:
    """How many contacts have a direction, and the errors of the bit-accurate model on these."""
    contacts = known_contacts(design, CONTACTS, SEED)
    exact = design.float_model(contacts.codes * design.adc.lsb)
    fixed = decode(design, design.model(contacts.codes).words)
    clear = exact.status == 0
    table: Errors = {}
    against = {"double precision, same codes": errors(exact, fixed), "the simulated contact": errors(contacts, fixed)}
    for reference, by_name in against.items():
        for key, name in _ERRORS.items():
            median, high = np.percentile(by_name[key][clear], (50, 95)) if clear.any() else (0.0, 0.0)
            table[reference, name] = float(median), float(high)
    return int(clear.sum()), table
