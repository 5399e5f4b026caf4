"""Routes: results of the products by their operator, facts of a frame by the fields that each block uses."""

from typing import Any

from tfra.hdl.parallel.core.core import Fact
from tfra.hdl.parallel.tfra.blocks import Blocks
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue


def product_routes(blocks: Blocks, sums: SumsQueue) -> list[tuple[Any, tuple[str, ...]]]:
    """Streams to which the results of these operators go; g goes to two blocks."""
    return [
        (blocks.weights.solution, ("c33_inv",)),
        (sums.b, ("sums_b",)),
        (sums.n, ("sums_n",)),
        (blocks.combine.residual, ("c33", "c31", "c32")),
        (blocks.sweep.g, ("c33",)),
        (blocks.sweep.normal, ("normal",)),
        (blocks.combine.products, ("pinv1", "pinv2", "pinv3")),
    ]


_REGULAR = ("contact", "traction")
_FRAME = {
    "weights": _REGULAR,
    "dependent": _REGULAR,
    "sweep": ("exponent",),
    "friction": _REGULAR,
    "resultant": _REGULAR,
    "gain": ("exponent", "magnitude", "contact", "traction"),
    "scaling": ("exponent", "contact", "traction", "saturated"),
}
_DIRECTION = {
    "dependent": ("cos", "sin", "sweep_y"),
    "combine": ("sweep_y",),
    "sweep": ("negative",),
    "friction": ("sweep_y", "negative"),
    "angle": ("cos", "sin"),
    "scaling": ("vanishing",),
}
_AFFINE = {
    "combine": ("alpha", "beta"),
    "friction": ("alpha", "beta"),
    "resultant": ("sums", "significant"),
    "scaling": ("vanishing",),
}
_CHOSEN = {
    "combine": ("mu_ind",),
    "combine.forced": ("mu_x", "mu_y"),
    "resultant": ("mu_x", "mu_y"),
    "scaling": ("index", "mu_x", "mu_y", "out_of_range"),
}
FACTS = (
    Fact("normaliser.frame", _FRAME, registered=True),
    Fact("centroids.direction", _DIRECTION, registered=True),
    Fact("dependent.affine", _AFFINE, registered=True),
    Fact("friction.chosen", _CHOSEN),
    Fact("resultant.total", {"gain": ("words", "exponent"), "scaling": ("words",)}),
    Fact("gain.gain", {"scaling": ()}),
)
"""Every fact of a frame, in the order of the blocks that compute them."""
