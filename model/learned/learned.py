"""The learned estimator in floating point: a resultant by the network, forces at the taxels by the elastic layer."""

import numpy as np
import numpy.typing as npt

from tfra.model.learned.field import residual, spread
from tfra.model.learned.network import Network, Weights
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status, check_frames, direction_deg, friction, in_contact, unit_scaled


class Learned:
    """The estimator of one sensor.

    ``threshold`` is the uncertainty over the normal force above which a frame is ``IMPLAUSIBLE``, as one that pulls is;
    ``contact_threshold`` in Pa is ``Tfra``'s.  Frames without traction are estimated as all
    others.  There is no sweep: ``sweep_index`` is -1.

    Raises ``ValueError`` that starts with the name of what is wrong.
    """

    def __init__(self, sensor: SensorArray, weights: Weights, threshold: float, contact_threshold: float = 0.0) -> None:
        if not threshold > 0:
            raise ValueError(f"threshold: more than zero is needed, got {threshold}")
        if not contact_threshold >= 0:
            raise ValueError(f"contact_threshold: zero or more is needed, got {contact_threshold}")
        self.sensor = sensor
        self.threshold = threshold
        self.contact_threshold = contact_threshold
        self._network = Network(sensor, weights)

    def __call__(self, frames: npt.ArrayLike) -> Result:
        """Forces of ``frames (n, rows, columns)`` in Pa; raises ``ValueError`` for a wrong shape or NaN."""
        b = check_frames(self.sensor, frames).reshape(-1, self.sensor.taxels)
        contact = in_contact(b, self.contact_threshold)
        scaled, exponent = unit_scaled(np.where(contact[:, None], b, 0.0))
        outputs = self._network(scaled * self.sensor.taxel_area)
        unit, uncertainty = outputs[:, :3], np.maximum(outputs[:, 3], 0.0)
        spreads = spread(self.sensor, scaled, unit)
        left = residual(self.sensor, scaled, spreads)
        phi, still = direction_deg(unit)
        implausible = (uncertainty > self.threshold * np.abs(unit[:, 2])) | (unit[:, 2] >= 0)
        status = (
            np.where(contact, 0, Status.NO_CONTACT)
            | np.where(contact & still, Status.NO_DIRECTION, 0)
            | np.where(contact & implausible, Status.IMPLAUSIBLE, 0)
        ).astype(np.int64)
        mu = friction(unit)
        mu_x, mu_y = mu * np.cos(np.radians(phi)), mu * np.sin(np.radians(phi))
        forces = np.ldexp(spreads, exponent[:, None, None])
        return Result(
            forces=forces.reshape(len(b), 3, self.sensor.rows, self.sensor.columns),
            resultant=np.ldexp(unit, exponent[:, None]),
            phi_deg=phi,
            mu=mu,
            mu_x=mu_x,
            mu_y=mu_y,
            sweep_index=np.full(len(b), -1, dtype=np.int64),
            status=status,
            uncertainty=np.ldexp(uncertainty, exponent),
            threshold=self.threshold,
            residual=left,
        )
