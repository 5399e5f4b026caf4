"""Lines of Python outside tests, of tests, of docs and of README, and their limits: ``python -m docs.tools.counts``."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[2]

LIMITS: dict[str, tuple[Callable[[str], bool], int]] = {
    "Python outside tests": (lambda name: name.endswith(".py") and not name.startswith("tests/"), 53_000),
    "tests": (lambda name: name.endswith(".py") and name.startswith("tests/"), 34_500),
    "docs": (lambda name: name.endswith(".md") and name.startswith("docs/"), 3_750),
    "README": (lambda name: name == "README.md", 120),
}
"""What is counted, by the names of the files, and the most lines."""


def counts() -> dict[str, int]:
    """Lines of all files in git, by the keys of ``LIMITS``."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    files = [name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]
    return {
        key: sum(len((ROOT / name).read_bytes().splitlines()) for name in files if belongs(name))
        for key, (belongs, _) in LIMITS.items()
    }


def main() -> int:
    """Print; 1 if there are more lines than allowed."""
    found = counts()
    for key, count in found.items():
        print(f"{key}: {count:,} lines of at most {LIMITS[key][1]:,}")
    return int(any(count > LIMITS[key][1] for key, count in found.items()))


if __name__ == "__main__":
    sys.exit(main())
