"""Line 5: wrong changes of netlists, of the model and of codegen, and whether words or tests show them."""

import tempfile
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from scipy import stats

from bench.scorecard.line import GATEWARE, Line, Measured, progress
from bench.scorecard.mutants import python
from bench.scorecard.mutants.mutations import Mutation
from bench.scorecard.mutants.verilog import CYCLES, Mutants
from bench.scorecard.record import kept
from bench.scorecard.words.drawn import drawn
from bench.scorecard.words.harness import Configuration

DRAWN, QUICK_DRAWN = (5, 13, 18, 19, 22), (19,)
"""Numbers of drawn configurations, whose cores are a serial one and parallel ones of both estimators."""
COUNT, QUICK_COUNT = 240, 40
WORKERS = 2
RTL_AIM, QUICK_AIM, PYTHON_AIM = 0.98, 0.6, 0.9
"""Least shares to be noticed; equivalent mutants are among those of a quick run, which has no proofs."""
SOURCES = (*GATEWARE, "sim", "bench/scorecard/aig.py", "bench/scorecard/words", "bench/scorecard/mutants")
TESTS = ("tests/model", "tests/codegen", "tests/hdl", "tests/sim", "tests/conftest.py")
Record = dict[str, Any]


def of_core(configuration: Configuration, count: int, quick: bool) -> Record:
    """What became of so many mutants of a core."""
    with tempfile.TemporaryDirectory() as folder:
        mutants = Mutants(configuration, Path(folder), count)
        left = mutants.all
        for cycles in CYCLES[:-1]:
            left = mutants.unnoticed(left, cycles)
        unproven = left if quick else mutants.unproven(left)
        survivors = unproven if quick else mutants.unnoticed(unproven, CYCLES[-1])
    found = {"name": configuration.name, "mutants": len(mutants.all), "equivalent": len(left) - len(unproven)}
    progress("{name}: {mutants} mutants, {equivalent} equivalent".format(**found) + f", {len(survivors)} survive")
    return found | {"survivors": [str(one) for one in survivors]}


def of_source(number: int, file: str, mutation: Mutation) -> Record:
    """What became of a mutant of a source file."""
    with tempfile.TemporaryDirectory() as folder:
        test = python.Copy(Path(folder)).judge(file, mutation)
    progress(f"{number}: {file}:{mutation.line} {mutation.kind}: {test or 'survives'}")
    return {"file": file, **vars(mutation), "test": test}


def share(noticed: int, of: int) -> str:
    """A share in words, with its 95 % interval."""
    interval = stats.binomtest(noticed, of).proportion_ci(0.95, method="wilson")
    percent = [f"{100 * part:.1f}" for part in (noticed / of, interval.low, interval.high)]
    return f"{noticed} of {of} ({percent[0]} %, 95 % interval {percent[1]} to {percent[2]})"


def judged(cores: Iterable[Record], sources: Iterable[Record], aim: float) -> Measured:
    """The line's figure."""
    cores, sources = list(cores), list(sources)
    sums = Counter[str]()
    for one in cores:
        sums.update({key: one[key] for key in ("mutants", "equivalent")}, survivors=len(one["survivors"]))
    rtl = sums["mutants"] - sums["equivalent"]
    figure = f"of netlists {share(rtl - sums['survivors'], rtl)}, {sums['equivalent']} more proven equivalent"
    passed = rtl - sums["survivors"] >= aim * rtl
    unnoticed = [one for one in sources if not one["test"]]
    noticed = len(sources) - len(unnoticed)
    if sources:
        figure += f"; of model and codegen {share(noticed, len(sources))}"
        passed &= rtl >= 1000 and noticed >= PYTHON_AIM * len(sources)
    return Measured(figure, passed, {"verilog": cores, "unnoticed": unnoticed})


def measure(quick: bool) -> Measured:
    """Mutants of some cores and sources, or some of one core; what was judged is kept until a source changes."""
    configurations = [replace(one, wrapped=False, cut_through=False) for one in drawn(max(DRAWN) + 1, 1)]
    if quick:
        cores = [of_core(configurations[number], QUICK_COUNT, True) for number in QUICK_DRAWN]
        return judged(cores, [], QUICK_AIM)
    key = replace(LINE, title="", target="").key(False)
    with ThreadPoolExecutor(WORKERS) as pool:
        tests = [
            pool.submit(kept, f"mutants-source{number}", key, partial(of_source, number, *one))
            for number, one in enumerate(python.mutants())
        ]
        words = [
            pool.submit(kept, f"mutants-core{number}", key, partial(of_core, configurations[number], COUNT, False))
            for number in DRAWN
        ]
        return judged([one.result() for one in words], [one.result() for one in tests], RTL_AIM)


LINE = Line(
    5,
    "wrong changes that are noticed: of cells' ports in a core's netlist, by its words and their cycles; of model and"
    " codegen, by tests",
    "98 % of 1,000 mutants of netlists, without those proven equivalent; 90 % of those of Python",
    "nothing around the cores (AXI, front end, UART, skins) is mutated, nor are clocks or the starts of scripts;"
    " equivalence is proven only where registers stay equal by induction, whatever flags and reachable states are."
    " Mutants of Python meet the tests of their place and of small cores for five minutes; the rest of `make test` may"
    " notice more. Tests were added for those that had survived, so the share of other mutants is lower.",
    (*SOURCES, *TESTS),
    measure,
)
