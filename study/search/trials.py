"""Finished trials of a search, in a table that survives a crash.

One commit a trial: SQLite with a write-ahead log by default, or any database that SQLAlchemy knows the URL of, for a
team.  A table holds any number of searches, each identified by the hash of its definition.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import (
    Column,
    Float,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    create_engine,
    event,
    insert,
    make_url,
    select,
)
from sqlalchemy.engine import Engine
from sqlalchemy.exc import IntegrityError, SQLAlchemyError

_TABLE = Table(
    "trials",
    MetaData(),
    Column("search", String(64), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("state", String(16), nullable=False),
    Column("content", Text, nullable=False),
    Column("seconds", Float, nullable=False),
)

COMPLETE, STOPPED, UNFIT = "complete", "stopped", "unfit"
"""States: measured on all frames; dropped after few; choices that do not fit together."""


class StoreError(ValueError):
    """The table can't be reached, read or written; the message says why in one line."""


@dataclass(frozen=True)
class Trial:
    """Trial ``number`` of the search: its choices and its result.

    ``indices``: index of each choice among its options; ``values``: measured objectives by name;
    ``attributes``: data that the sampler needs later; ``reason``: why the choices do not fit.
    """

    number: int
    state: str
    indices: Mapping[str, int]
    values: Mapping[str, float] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)
    reason: str = ""


class Trials:
    """The trials of one search in the table at ``url``; ``search`` is the hash of its definition.

    Raises :class:`StoreError`.
    """

    def __init__(self, url: str, search: str) -> None:
        self._search = search
        try:
            self._engine = _engine(url)
            _TABLE.metadata.create_all(self._engine)
        except (SQLAlchemyError, ImportError) as error:
            raise StoreError(_line(error)) from None

    def __call__(self) -> list[Trial]:
        """All trials, in order."""
        rows = select(_TABLE.c.number, _TABLE.c.state, _TABLE.c.content)
        try:
            with self._engine.connect() as connection:
                found = connection.execute(rows.where(_TABLE.c.search == self._search).order_by(_TABLE.c.number)).all()
            return [Trial(number, state, **json.loads(content)) for number, state, content in found]
        except (SQLAlchemyError, TypeError, ValueError) as error:
            raise StoreError(_line(error)) from None

    def add(self, trial: Trial, seconds: float) -> None:
        """Store ``trial`` for good; another process may have stored the same before."""
        names = ("indices", "values", "attributes", "reason")
        content = json.dumps({name: getattr(trial, name) for name in names}, sort_keys=True)
        row = {"number": trial.number, "state": trial.state, "content": content, "seconds": seconds}
        try:
            with self._engine.begin() as connection:
                connection.execute(insert(_TABLE).values(search=self._search, **row))
        except IntegrityError:
            return
        except SQLAlchemyError as error:
            raise StoreError(_line(error)) from None


def public(url: str) -> str:
    """``url`` without its password, for display."""
    try:
        return make_url(url).render_as_string(hide_password=True)
    except SQLAlchemyError:
        return url.partition(":")[0]


def sqlite(path: Path) -> str:
    """URL of the table in the file at ``path``."""
    return f"sqlite:///{path.absolute()}"


def _engine(url: str) -> Engine:
    engine = create_engine(url)
    if engine.dialect.name == "sqlite":

        @event.listens_for(engine, "connect")
        def _make_durable(connection: Any, _: Any) -> None:
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = FULL")

    return engine


def _line(error: Exception) -> str:
    """The reason of the driver, without the statement."""
    return str(getattr(error, "orig", None) or error).splitlines()[0]
