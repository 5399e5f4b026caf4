"""Finished trials of a search, in a table that survives a crash.

One commit a trial: a file of SQLite with a write-ahead log, or a team's PostgreSQL.  A table holds any number of
searches, each identified by the hash of its definition.
"""

import json
import re
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from tfra.runtime.errors import LONGEST_REASON, shortened

PATIENCE = 5.0
"""Seconds to wait for another writer of the same file."""

_DRIVERS = {"sqlite": "sqlite3", "postgresql": "psycopg"}
"""Modules of PEP 249 by the scheme of the URL."""

_CREATE = """
CREATE TABLE IF NOT EXISTS trials (
    search VARCHAR(64) NOT NULL,
    number INTEGER NOT NULL,
    state VARCHAR(16) NOT NULL,
    content TEXT NOT NULL,
    seconds FLOAT NOT NULL,
    PRIMARY KEY (search, number)
)"""
_SELECT = "SELECT number, state, content FROM trials WHERE search = ? ORDER BY number"
_INSERT = "INSERT INTO trials VALUES (?, ?, ?, ?, ?) ON CONFLICT DO NOTHING"

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

    ``url`` is sqlite:///FILE or postgresql://USER:PASSWORD@HOST/DATABASE.  Raises :class:`StoreError`.
    """

    def __init__(self, url: str, search: str) -> None:
        self._url = url
        self._search = search
        self._driver = _driver(url)
        with self._transaction() as execute:
            execute(_CREATE)

    def __call__(self) -> list[Trial]:
        """All trials, in order."""
        with self._transaction() as execute:
            rows = execute(_SELECT, (self._search,)).fetchall()
        try:
            return [Trial(number, state, **json.loads(content)) for number, state, content in rows]
        except (TypeError, ValueError, RecursionError) as error:
            raise StoreError(_line(error)) from None

    def add(self, trial: Trial, seconds: float) -> None:
        """Store ``trial`` for good, unless another process has stored the same before."""
        names = ("indices", "values", "attributes", "reason")
        content = json.dumps({name: getattr(trial, name) for name in names}, sort_keys=True)
        with self._transaction() as execute:
            execute(_INSERT, (self._search, trial.number, trial.state, content, seconds))

    @contextmanager
    def _transaction(self) -> Iterator[Callable[..., Any]]:
        """Yield a function that executes a statement; all of them are committed together."""
        mark = "?" if self._driver.paramstyle == "qmark" else "%s"
        try:
            with closing(self._connection()) as connection, connection:
                yield lambda statement, *values: connection.execute(statement.replace("?", mark), *values)
        except (self._driver.Error, UnicodeError) as error:  # the latter for damaged text
            raise StoreError(_line(error)) from None

    def _connection(self) -> Any:
        if self._driver is not sqlite3:
            return self._driver.connect(self._url)
        connection = sqlite3.connect(self._url.removeprefix("sqlite:///"), PATIENCE)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        return connection


def public(url: str) -> str:
    """``url`` without its password, for display."""
    return re.sub(r"(?<=://)([^/@:]*):.*@", r"\1:***@", url)


def sqlite(path: Path) -> str:
    """URL of the table in the file at ``path``."""
    return f"sqlite:///{path.absolute()}"


def _driver(url: str) -> Any:
    scheme, _, rest = url.partition("://")
    if scheme not in _DRIVERS or not rest:
        raise StoreError("a URL sqlite:///FILE or postgresql://HOST/DATABASE is needed")
    try:
        return import_module(_DRIVERS[scheme])
    except ImportError:
        raise StoreError(f"needs the package {_DRIVERS[scheme]}, which is not installed") from None


def _line(error: Exception) -> str:
    return shortened((str(error) or type(error).__name__).splitlines()[0], LONGEST_REASON)
