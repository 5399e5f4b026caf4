"""One frame at a time, for control loops: the compiled core, from stress to forces in some microseconds."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tfra.codegen.config.core import check_core
from tfra.codegen.config.read import Project
from tfra.model.arrays import Floats
from tfra.runtime.errors import InputError
from tfra.sim.compiled import Compiled


class Step(NamedTuple):
    """A frame: ``resultant (3,)`` and ``forces (3, rows, columns)`` in N, ``phi_deg``, ``mu`` and ``status``.

    ``forces`` is None from a core that leaves them out; ``status`` has the bits of ``tfra.Status``.
    """

    resultant: Floats
    phi_deg: float
    mu: float
    status: int
    forces: Floats | None


class Stepper:
    """Called with a frame of stress in Pa, ``(rows, columns)``; returns its :class:`Step`."""

    def __init__(self, project: Project) -> None:
        check_core(project)
        design = project.design
        self._shape = (design.sensor.rows, design.sensor.columns)
        self._stress, self._words = np.zeros(self._shape), np.zeros(design.frame_words)
        self._step = Compiled(design).stepper()
        self._at = self._stress.ctypes.data, self._words.ctypes.data
        start = {field.name: field.start for field in design.layout}
        self._phi, self._mu, self._status = start["phi"], start["mu"], start["status"]
        self._resultant = slice(start["resultant"], start["resultant"] + 3)
        forces = start.get("forces")
        self._forces = None if forces is None else slice(forces, forces + 3 * design.sensor.taxels)

    def __call__(self, frame: npt.ArrayLike) -> Step:
        """Find the forces in ``frame``; stress beyond full scale is limited, and its status says so.

        Raises ``tfra.InputError`` for a frame of another shape, and for one that is not finite.
        """
        given = np.asarray(frame)
        if given.shape != self._shape:
            raise InputError("Stepper", "frame", f"{self._shape} is needed, got {given.shape}")
        self._stress[...] = given
        if taxel := self._step(*self._at):
            row, column = divmod(taxel - 1, self._shape[1])
            raise InputError("Stepper", "frame", f"row {row}, column {column} is {given[row, column]}")
        words = self._words.copy()
        forces = None if self._forces is None else words[self._forces].reshape(3, *self._shape)
        scalars = words[self._phi], words[self._mu], words[self._status]
        return Step(words[self._resultant], float(scalars[0]), float(scalars[1]), int(scalars[2]), forces)
