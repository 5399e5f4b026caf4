"""Ground-truth forces of taxels: the exact part of a contact's load on the cell of each taxel."""

from collections.abc import Sequence

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact, Contacts, ContactShape
from tfra.model.sensor import SensorArray


def cell_shares(sensor: SensorArray, contacts: Sequence[Contact] | Contacts) -> Floats:
    """Return the share of each contact's load on each taxel's pitch_x x pitch_y cell, ``(n, rows, columns)``.

    The cells tile the block, so that the shares of a contact inside it add up to 1.  No quadrature: profiles are
    integrated in closed form (:meth:`ContactShape.gathered`).
    """
    loads = contacts if isinstance(contacts, Contacts) else Contacts.of(contacts)
    x = (np.arange(sensor.columns + 1) - 0.5) * sensor.pitch_x
    y = (np.arange(sensor.rows + 1) - 0.5) * sensor.pitch_y
    shares = np.empty((len(loads), sensor.rows, sensor.columns))
    for shape in ContactShape:
        which = np.flatnonzero(loads.shape == shape.value)
        center, half = loads.center[which, :, None], loads.half[which, :, None]
        u, v = (x - center[:, 0]) / half[:, 0], (y - center[:, 1]) / half[:, 1]
        corners = shape.gathered(u[:, None, :], v[:, :, None])
        shares[which] = np.diff(np.diff(corners, axis=1), axis=2)
    return np.maximum(shares, 0.0)  # rounding leaves some below


def taxel_forces(sensor: SensorArray, contacts: Sequence[Contact] | Contacts) -> Floats:
    """Return the load on each taxel's cell, the f of Eq. 3: ``(n, 3, rows, columns)`` in N."""
    loads = contacts if isinstance(contacts, Contacts) else Contacts.of(contacts)
    return np.asarray(loads.force[:, :, None, None] * cell_shares(sensor, loads)[:, None])
