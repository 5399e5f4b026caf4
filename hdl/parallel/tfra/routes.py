"""Routes: results of the products by their operator, facts of a frame by the fields that each block uses."""

from dataclasses import dataclass
from typing import Any

from tfra.hdl.parallel.core.core import Fact, FactRoute
from tfra.hdl.parallel.tfra.blocks import Blocks
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue


@dataclass(frozen=True)
class ProductRoute:
    """Results of ``operators`` go to the stream ``sink``."""

    operators: tuple[str, ...]
    sink: Any


def product_routes(blocks: Blocks, sums: SumsQueue) -> tuple[ProductRoute, ...]:
    """Routes of the results of all products; g goes to two blocks."""
    return (
        ProductRoute(("c33_inv",), blocks.weights.solution),
        ProductRoute(("sums_b",), sums.b),
        ProductRoute(("sums_n",), sums.n),
        ProductRoute(("c33", "c31", "c32"), blocks.combine.residual),
        ProductRoute(("c33",), blocks.sweep.g),
        ProductRoute(("normal",), blocks.sweep.normal),
        ProductRoute(("pinv1", "pinv2", "pinv3"), blocks.combine.products),
    )


def facts(blocks: Blocks) -> tuple[Fact, ...]:
    """Every fact of a frame, in the order of the blocks that compute them."""
    return (*_facts_of_the_input(blocks), *_facts_of_the_results(blocks))


def _facts_of_the_input(b: Blocks) -> tuple[Fact, ...]:
    regular = ("contact", "traction")
    return (
        Fact(
            "frame",
            b.normaliser.frame,
            (
                FactRoute("weights", b.weights.frame, regular),
                FactRoute("dependent", b.dependent.frame, regular),
                FactRoute("sweep", b.sweep.frame, ("exponent",)),
                FactRoute("friction", b.friction.frame, regular),
                FactRoute("resultant", b.resultant.frame, regular),
                FactRoute("gain", b.gain.frame, ("exponent", "magnitude", "contact", "traction")),
                FactRoute("scaling", b.scaling.frame, ("exponent", "contact", "traction", "saturated")),
            ),
            registered=True,
        ),
        Fact(
            "direction",
            b.centroids.direction,
            (
                FactRoute("dependent", b.dependent.direction, ("cos", "sin", "sweep_y")),
                FactRoute("combine", b.combine.direction, ("sweep_y",)),
                FactRoute("sweep", b.sweep.direction, ("negative",)),
                FactRoute("friction", b.friction.direction, ("sweep_y", "negative")),
                FactRoute("angle", b.angle.direction, ("cos", "sin")),
                FactRoute("scaling", b.scaling.direction, ("vanishing",)),
            ),
            registered=True,
        ),
    )


def _facts_of_the_results(b: Blocks) -> tuple[Fact, ...]:
    return (
        Fact(
            "affine",
            b.dependent.affine,
            (
                FactRoute("combine", b.combine.affine, ("alpha", "beta")),
                FactRoute("friction", b.friction.affine, ("alpha", "beta")),
                FactRoute("resultant", b.resultant.affine, ("sums", "significant")),
                FactRoute("scaling", b.scaling.affine, ("vanishing",)),
            ),
            registered=True,
        ),
        Fact(
            "chosen",
            b.friction.chosen,
            (
                FactRoute("combine", b.combine.chosen, ("mu_ind",)),
                FactRoute("combine_forced", b.combine.forced, ("mu_x", "mu_y")),
                FactRoute("resultant", b.resultant.chosen, ("mu_x", "mu_y")),
                FactRoute("scaling", b.scaling.chosen, ("index", "mu_x", "mu_y", "out_of_range")),
            ),
        ),
        Fact(
            "total",
            b.resultant.total,
            (
                FactRoute("gain", b.gain.total, ("words", "exponent")),
                FactRoute("scaling", b.scaling.total, ("words",)),
            ),
        ),
        Fact("gain", b.gain.gain, (FactRoute("scaling", b.scaling.gain),)),
    )
