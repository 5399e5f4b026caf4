"""Proofs of the gateware: what is claimed of its blocks, proven by k-induction; every claim reached, and broken.

``python -m bench.formal.formal [BLOCK ...]`` proves the claims of all blocks, or of those named and keeps what is known
of the others; writes ``bench/results/formal.json`` and the table in docs/formal.md; exits with 1 for any claim that is
not proven, whose case is never reached, or whose mutant nothing notices.
"""

import argparse
import sys
import warnings
from collections.abc import Iterable
from typing import Any

from amaranth.hdl import UnusedElaboratable

from bench.formal import around, axi, framer, numbers, pipelines, reader, skin, streams, vectors
from bench.formal.prove import Proof, judge
from bench.publish import publish, stored

MODULES = (streams, reader, around, framer, skin, axi, numbers, pipelines, vectors)
PROOFS = [proof for module in MODULES for proof in module.PROOFS]


def measure(proof: Proof) -> dict[str, Any]:
    """What became of ``proof``, as JSON."""
    result = judge(proof)
    return {
        "depth": proof.depth,
        "proven": result.proven,
        "covered": result.covered,
        "claims": {claim: claim in result.killed for claim in proof.mutants},
        "seconds": result.seconds,
    }


def complete(one: dict[str, Any]) -> bool:
    """Whether every claim is proven and reached, and its mutant noticed."""
    return one["proven"] and one["covered"] and all(one["claims"].values())


def table(record: dict[str, dict[str, Any]]) -> str:
    """A row for each block."""
    lines = [
        "| block | claims | cycles of the induction | proven | reached | mutants noticed |",
        "|---|---|---|---|---|---|",
    ]
    for block, one in record.items():
        claims, killed = one["claims"], sum(one["claims"].values())
        facts = (
            "yes" if one["proven"] else "**no**",
            "yes" if one["covered"] else "**no**",
            f"{killed} of {len(claims)}",
        )
        lines.append(f"| `{block}` | {'; '.join(claims)} | {one['depth']} | {' | '.join(facts)} |")
    return "\n".join(lines)


def summary(record: Iterable[dict[str, Any]]) -> str:
    """A sentence of all proofs."""
    blocks = list(record)
    claims = [one for one in blocks for _ in one["claims"]]
    proven = [one for one in claims if one["proven"] and one["covered"]]
    killed = sum(sum(one["claims"].values()) for one in blocks)
    minutes = round(sum(one["seconds"] for one in blocks) / 60)
    return (
        f"Of {len(claims)} claims of {len(blocks)} blocks {len(proven)} are proven for all time and "
        f"reached; {killed} of {len(claims)} mutants are noticed. It took {minutes} minutes."
    )


def main() -> int:
    """Prove, publish; 1 if a claim isn't proven, reached and broken by its mutant."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("blocks", nargs="*", metavar="BLOCK", help="prove the claims of these alone")
    chosen = parser.parse_args().blocks
    warnings.simplefilter("ignore", UnusedElaboratable)
    known = stored("formal") if chosen else {}
    record = {}
    for proof in PROOFS:
        if chosen and proof.subject.__name__ not in chosen and proof.block in known:
            record[proof.block] = known[proof.block]
        else:
            record[proof.block] = one = measure(proof)
            print(f"{proof.block}: {'complete' if complete(one) else 'NOT complete'}, {one['seconds']} s", flush=True)
    publish("formal", record, f"{table(record)}\n\n{summary(record.values())}", "docs/formal.md")
    return int(not all(map(complete, record.values())))


if __name__ == "__main__":
    sys.exit(main())
