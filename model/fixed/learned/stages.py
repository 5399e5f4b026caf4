"""The stages of the learned estimator: the name of a block in the model, in the gateware and in a report."""

from enum import StrEnum


class Stage(StrEnum):
    """In dataflow order."""

    NORMALISER = "normaliser"
    MATVEC = "matvec"
    ACTIVATION = "activation"
    TOTAL = "total"
    RESULTANT = "resultant"
    ANGLE = "angle"
    FRICTION = "friction"
    FIELD = "field"
    SHARE = "share"
    WORDS = "words"
