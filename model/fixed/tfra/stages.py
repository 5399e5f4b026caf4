"""The stages of TFRA: the name of a block in the model, in the gateware and in the report of a verification."""

from enum import StrEnum


class Stage(StrEnum):
    """In dataflow order."""

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
