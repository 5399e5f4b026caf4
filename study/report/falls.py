"""Totals that are smaller with fewer bits of the converter: where, by how much for sure, and why."""

from dataclasses import dataclass
from itertools import product

import polars as pl

from tfra.report.table import number
from tfra.study.errors.cascade import Step, View
from tfra.study.errors.statistics import CONFIDENCE
from tfra.study.report.figure import Row, interval
from tfra.study.report.labels import QUANTITIES, STATISTICS, Tables


@dataclass(frozen=True)
class Fall:
    """Rows of one noise and quantity: the totals of ``few`` bits and of the ``most``, the larger one.

    ``before`` and ``own`` are of the frames of ``few``: the total without the converter, and the converter's share.
    """

    few: Row
    most: Row
    before: Row
    own: Row

    def sentence(self, quantity: str, statistic: str) -> str:
        """Both totals with their intervals, and what the numbers say about the reason."""
        few, most, amount = self.few, self.most, QUANTITIES[quantity].amount
        noise, confidence = (
            f"{share:g}\N{NO-BREAK SPACE}%" for share in (100 * few["noise_share_of_peak"], 100 * CONFIDENCE)
        )
        of_few, of_most = (f"{amount(row[statistic], 3)} ({interval(row, statistic, 3)})" for row in (few, most))
        return (
            f"Smaller with fewer bits: at a noise of {noise} of the peak, the {STATISTICS[statistic]} of the total is "
            f"{of_few} with {few['bits']} bits and {of_most} with {most['bits']}; in brackets are {confidence} "
            f"intervals. {self._reason(quantity, statistic)}"
        )

    def _reason(self, quantity: str, statistic: str) -> str:
        few, most = self.few, self.most
        before, own = (QUANTITIES[quantity].amount(row[statistic], 3) for row in (self.before, self.own))
        if few[f"{statistic}_high"] >= most[f"{statistic}_low"]:
            return f"They overlap: among {few['count']:,} frames this may be chance."
        if few[statistic] >= self.before[statistic]:
            left_out = f"{few['left_out']:,} are left out, with {most['bits']} bits {most['left_out']:,}"
            return f"The frames are others: {left_out}; without the converter those that remain have {before}."
        if few["noise_share_of_peak"]:
            return f"Without the converter the same frames have {before}: its steps round noise away."
        return f"Without the converter the same frames have {before}: its share, {own}, cancels a part of that."


def falls(converter: pl.DataFrame, quantity: str, statistic: str) -> dict[tuple[float, int], Fall]:
    """By noise and bits, the totals that are smaller than with most bits at the same noise, as far as digits show."""
    rows = converter.filter(quantity=quantity).drop_nulls(statistic).sort("bits").to_dicts()
    total, before, own = (
        {(row["noise_share_of_peak"], row["bits"]): row for row in rows if (row["step"], row["view"]) == kind}
        for kind in ((Step.CONVERTER, View.TOTAL), (Step.NOISE, View.TOTAL), (Step.CONVERTER, View.OWN))
    )
    most = {noise: row for (noise, _), row in total.items()}  # the last has most bits
    return {
        cell: Fall(row, most[cell[0]], before[cell], own[cell])
        for cell, row in total.items()
        if row[statistic] < most[cell[0]][statistic]
        and number(row[statistic], 2) != number(most[cell[0]][statistic], 2)
    }


def fall_sentences(tables: Tables) -> dict[tuple[str, ...], str]:
    """A sentence for each choice of quantity and statistic that has such totals: of the one that falls most."""
    sentences: dict[tuple[str, ...], str] = {}
    for quantity, statistic in product(QUANTITIES, STATISTICS):
        if found := falls(tables["converter"], quantity, statistic).values():
            most = min(found, key=lambda fall: fall.few[statistic] / fall.most[statistic])
            sentences[quantity, statistic] = most.sentence(quantity, statistic)
    return sentences
