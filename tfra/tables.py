"""Results as tables: of polars, and of a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from tfra.runtime.errors import require

if TYPE_CHECKING:
    import polars as pl

Columns = Mapping[str, npt.NDArray[Any]]

SHOWN = 12
"""Rows of a table in a notebook."""


def dataframe(call: str, columns: Columns) -> pl.DataFrame:
    """The ``columns`` as a table of polars; raises ``InputError`` that names ``call`` where it is missing."""
    require(call, "tables", "polars")
    import polars as pl

    return pl.DataFrame(dict(columns))


def html_table(columns: Columns) -> str:
    """The first rows of ``columns``."""
    shown = {name: values[:SHOWN].tolist() for name, values in columns.items()}
    head = "".join(f"<th>{escape(name)}</th>" for name in shown)
    rows = ("".join(f"<td>{value:.5g}</td>" for value in row) for row in zip(*shown.values(), strict=True))
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"
