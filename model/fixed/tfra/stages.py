"""The stages of TFRA: the name of a block in the model, in the gateware and in what a verification reports."""

from __future__ import annotations

from enum import StrEnum


class Stage(StrEnum):
    """In the order in which data reach them."""

    NORMALISER = "normaliser"
    CENTROIDS = "centroids"
    MATVEC = "matvec"
    WEIGHTS = "weights"
    DEPENDENT = "dependent"
    COMBINE = "combine"
    SWEEP = "sweep"
    FRICTION = "friction"
    RESULTANT = "resultant"
    GAIN = "gain"
    FORCES = "forces"
    ANGLE = "angle"
    SCALING = "scaling"
