"""The page of a skin's study, in the form of :mod:`tfra.study.report.page`."""

from collections.abc import Sequence

import polars as pl

from tfra.model.skin.skin import Skin
from tfra.report.table import listed, number
from tfra.study.errors.cascade import Step, View
from tfra.study.errors.statistics import BEYOND
from tfra.study.report import error_charts
from tfra.study.report.labels import CLOSE, QUANTITIES, Tables, cost_amount
from tfra.study.report.page import Chart, Section, by_view, compose
from tfra.study.report.summary import HEADLINE, advice, first_part, shares, sufficient, sufficient_product_bits
from tfra.study.skins import charts
from tfra.study.skins.statistics import ALL, ALONE, GAP

ENOUGH = 2 * BEYOND
"""Contacts of a group that a sentence may be about, as many as a median takes."""

SECTIONS = (
    Section(
        "finding",
        "Contacts that are found",
        "A dot is a share of contacts; its line is the 95 % confidence interval. Missed ones have no region near them; "
        "of these, merged ones lie in the region of another one or in the gap about it. Invented ones are found, but "
        "not there, and their share is that of the contacts found. Finding is exact in integers, so the arithmetic "
        "changes none of it. On the left end is a share of none.",
        ("finding", "marked"),
        (
            Chart("finding", charts.finding, ("part",), "After each step"),
            Chart("finding-groups", charts.finding_by_group, ("part",), "By what is around, in the core"),
        ),
    ),
    Section(
        "cascade",
        "Where the error comes from",
        "Of contacts that all steps find. A dot is the median of the error’s magnitude; the line ends at the 95th "
        "percentile. Blue is the change from the result of the step before; vermilion is the error against the ground "
        "truth after the step. The place is that of the region’s centroid, which friction drags aside. A triangle at "
        "the left end is a median of zero.",
        ("errors",),
        (Chart("cascade", error_charts.cascade, ("quantity", "part")),),
    ),
    Section(
        "groups",
        "Many contacts, and near ones",
        "The same errors against the ground truth, by the number of contacts in the frame and by the gap between a "
        "footprint and the nearest other one, along the axis where it is larger. A dot is the median; the line ends at "
        "the 95th percentile, if there are enough contacts for one.",
        ("groups",),
        (Chart("groups", charts.groups, ("quantity", "part")),),
    ),
    Section(
        "uniform",
        "How many bits",
        "All coefficients and operands of the window have the same number of bits. The dashed line is the error "
        "without any arithmetic: where the total (vermilion) reaches it, more bits gain nothing. The dotted line is "
        "the method’s own error on exact stress.",
        ("uniform",),
        (Chart("uniform", error_charts.uniform, ("quantity", "statistic")),),
    ),
    Section(
        "converter",
        "Converter and noise",
        "A cell is the error after the converter, in the quantity’s unit; dark is large. Where a row stops changing to "
        "the right, only noise and method are left. A total smaller than the last of its row has its 95 % interval "
        "below. A cross marks impossible combinations, “few” those with too few contacts.",
        ("converter",),
        (
            *by_view("converter", error_charts.converter),
            Chart("converter-finding", charts.converter_finding, (), "Contacts that are found"),
        ),
    ),
)


def render(tables: Tables, skin: Skin, pending: Sequence[str] = ()) -> str:
    """The page of a study of ``skin``; arguments as of :func:`tfra.study.report.page.render`."""
    title = f"Contacts, errors and word lengths of {skin.name}"
    return compose(SECTIONS, tables, title, summary(tables, skin), notes(tables), pending)


def summary(tables: Tables, skin: Skin) -> list[str]:
    """Lines: what was asked, what is found, what limits the accuracy, which lengths are enough, what they save."""
    answers = {
        "Found": _found(tables),
        "Limit": shares(tables, skin.window),
        "Enough": sufficient(tables),
        "Saved": _saved(tables, skin),
        "Next": advice(tables),
    }
    lines = [f"{name}: {words}" for name, words in answers.items() if words]
    rows, columns = skin.shape
    asked = (
        f"Asked: how right is `{skin.name}` ({skin.sensor.rows}×{skin.sensor.columns} taxels, windows of "
        f"{rows}×{columns}, {skin.adc.bits}-bit converter, arithmetic `{skin.window.formats.name}`), and how many bits "
        f"does its window need, if its error may change by {CLOSE}?"
    )
    return [asked, *lines] if lines else []


def notes(tables: Tables) -> list[str]:
    """Meaning of the summary's numbers."""
    if "errors" not in tables:
        return []
    part, errors = first_part(tables, "errors")
    total = errors.filter(pl.col("quantity").is_in(list(HEADLINE)), step=Step.ARITHMETIC, view=View.TOTAL)
    counts = [f"{n:,} for {QUANTITIES[name].label}" for name, n in total.select("quantity", "count").iter_rows()]
    marked = first_part(tables, "marked")[1].filter(step=Step.ARITHMETIC, status="input_saturated")
    return [
        f"Amounts are medians of the errors' magnitudes over contacts of {part} frames that all steps find, "
        f"{listed(counts)}; φ has none without friction. The share of a step is its change of the result of the step "
        "before; all together is the error of the core's result against the ground truth. The error of φ is an angle; "
        "that of F is the length of the difference vector in percent of the true |F|. A change by less than "
        f"{CLOSE} is one of both the median and the 95th percentile of both errors.",
        *(
            f"{n:,} of {of:,} contacts found have a taxel at an end of the converter's range; they are kept."
            for n, of in marked.select("contacts", "of").iter_rows()
        ),
        "Word lengths and converters are compared on training frames.",
    ]


def _found(tables: Tables) -> str:
    """Like ``1.2 % of 2,300 contacts are missed, 1.1 % since they merge with others; ...``."""
    if "finding" not in tables:
        return ""
    _, table = first_part(tables, "finding")
    core = table.filter(step=Step.ARITHMETIC)
    missed, merged, invented = (
        core.filter(split=ALL, kind=kind).row(0, named=True) for kind in ("missed", "merged", "invented")
    )
    words = f"{_percent(missed)} of {missed['of']:,} contacts are missed"
    words += f", {_percent(merged)} since they merge with another" if merged["count"] else ""
    words += f"; {_percent(invented)} of those found are invented"
    near = core.filter(pl.col("count") > 0, pl.col("of") >= ENOUGH, pl.col("group") != ALONE, split=GAP, kind="missed")
    if len(near):
        row = near.sort("rate", descending=True).row(0, named=True)
        words += f"; worst is a gap of {row['group']} pitches, where {_percent(row)} of {row['of']:,} are missed"
    return f"{words}."


def _percent(row: dict[str, float]) -> str:
    return f"{number(100 * (row['rate'] or 0.0), 2)}\N{NO-BREAK SPACE}%"


def _saved(tables: Tables, skin: Skin) -> str:
    """Coefficients of the shortest uniform lengths that are enough, and of those of CONFIG."""
    if not {"uniform", "errors"} <= set(tables) or (bits := sufficient_product_bits(tables)) is None:
        return ""
    cost, base = tables["uniform"].filter(bits=bits)["coefficient_kbit"][0], skin.window.coefficient_bits / 1000
    less = 100 * (1 - cost / base)
    amount = f"{number(abs(less), 2)}\N{NO-BREAK SPACE}% {'less' if less > 0 else 'more'} than that of CONFIG"
    return f"the window of {bits}×{bits} bits has {cost_amount('coefficient_kbit', cost)}, {amount}."
