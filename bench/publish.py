"""Measurements become ``bench/results/NAME.json`` and the table between ``<!-- NAME -->`` marks in README.md."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent


def publish(name: str, record: dict[str, Any], table: str) -> None:
    """Print ``table``, store ``record`` and put the table into the README; raises ``ValueError`` without its marks."""
    print(table)
    results = ROOT / "bench" / "results"
    results.mkdir(exist_ok=True)
    (results / f"{name}.json").write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n")
    readme = ROOT / "README.md"
    text, found = re.subn(
        rf"(<!-- {name} -->\n).*?(<!-- end {name} -->)",
        lambda match: f"{match[1]}{table}\n{match[2]}",
        readme.read_text(),
        flags=re.DOTALL,
    )
    if found != 1:
        raise ValueError(f"README.md: one pair of marks <!-- {name} --> is needed, found {found}")
    readme.write_text(text)
