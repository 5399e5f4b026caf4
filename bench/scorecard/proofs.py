"""Line 3: claims of single blocks, proven for all time; `make formal` writes them down one by one."""

from bench.formal.formal import PROOFS, complete
from bench.formal.formal import measure as prove
from bench.scorecard.line import Line, Measured, progress

QUICK = 4
"""Every so many proofs is made in a quick run."""


def measure(quick: bool) -> Measured:
    """All proofs, or some of them."""
    found = {}
    for proof in PROOFS[:: QUICK if quick else 1]:
        found[proof.block] = one = prove(proof)
        progress(f"{proof.block}: {'complete' if complete(one) else 'not complete'}")
    whole = sum(len(one["claims"]) for one in found.values() if complete(one))
    claims = sum(len(one["claims"]) for one in found.values())
    figure = f"{whole} of {claims} claims of {len(found)} blocks are proven and reached, and their mutants noticed"
    return Measured(figure, whole == claims, {block: complete(one) for block, one in found.items()})


LINE = Line(
    3,
    "claims of streams, buses, registers, arithmetic and pipelines proven by k-induction",
    "all proven, reached, and broken by a mutant",
    "whole cores, products, the front end's intake, the search of skins, UART and the serial core have no proofs.",
    ("hdl", "model", "bench/formal", "bench/scorecard/proofs.py"),
    measure,
)
