"""Measurements become ``bench/results/NAME.json`` and the table between ``<!-- NAME -->`` marks in a page."""

import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent


def publish(name: str, record: dict[str, Any], table: str, page: str = "docs/measured.md") -> None:
    """Store ``record``, print ``table`` and put it into ``page``; raises ``ValueError`` without its marks."""
    store(name, record)
    insert(name, table, page)


def store(name: str, record: Any) -> None:
    """Write ``bench/results/NAME.json``."""
    results = ROOT / "bench" / "results"
    results.mkdir(exist_ok=True)
    (results / f"{name}.json").write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n")


def stored(name: str) -> Any:
    """The content of ``bench/results/NAME.json``."""
    return json.loads((ROOT / "bench" / "results" / f"{name}.json").read_text())


def insert(name: str, table: str, page: str = "docs/measured.md") -> None:
    """Print ``table`` and put it between its marks in ``page``, relative to the root.

    Raises ``ValueError`` unless the page has exactly one pair of marks.
    """
    print(table)
    path = ROOT / page
    text, found = re.subn(
        rf"(<!-- {name} -->\n).*?(<!-- end {name} -->)",
        lambda match: f"{match[1]}{table}\n{match[2]}",
        path.read_text(),
        flags=re.DOTALL,
    )
    if found != 1:
        raise ValueError(f"{page}: one pair of marks <!-- {name} --> is needed, found {found}")
    path.write_text(text)
