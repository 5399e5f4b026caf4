"""Baselines: resources and frequency of a core, by the versions of the tools.

A file of baselines is an object: a key made of versions, then ``resources`` and ``mhz``, of one subject and target.
"""

from collections.abc import Mapping
from typing import Any

GROWTH = 0.05
"""A resource may grow by this share before it counts as a regression."""
SLOWDOWN = 0.15
"""The frequency may fall by this share, since seeds differ by several per cent."""

REMEASURE = "make baselines"


def key(tools: Mapping[str, str]) -> str:
    """The baseline's name of these versions."""
    return ", ".join(f"{name} {number}" for name, number in sorted(tools.items()))


def entry(found: Mapping[str, Any]) -> dict[str, Any]:
    """The part of a report that a baseline keeps."""
    clock = found["clock"]
    return {
        "resources": {name: row["used"] for name, row in found["resources"].items()},
        "mhz": clock["median_mhz"] if clock else None,
    }


def compare(found: Mapping[str, Any], baselines: Mapping[str, Any]) -> list[str]:
    """Sentences on regressions from the baseline of the same tools; empty if there is none.

    Raises ``ValueError``, with the command that measures anew, for versions without a baseline and for a baseline
    that is not one.
    """
    version = key(found["tools"])
    if version not in baselines:
        raise ValueError(f"there is no baseline of {version}: {REMEASURE}")
    old, new = baselines[version], entry(found)
    if _kinds(old) != _kinds(new):
        raise ValueError(f"the baseline of {version} is damaged: {REMEASURE}")
    worse = [
        f"{name}: {used:,}, the baseline has {before:,}"
        for name, used in new["resources"].items()
        if used > (before := old["resources"][name]) * (1 + GROWTH)
    ]
    if new["mhz"] is not None and new["mhz"] < old["mhz"] * (1 - SLOWDOWN):
        worse.append(f"Fmax: {new['mhz']} MHz, the baseline has {old['mhz']} MHz")
    return worse


def _kinds(value: Any) -> Any:
    """The types of an entry, by key, to compare two entries."""
    return {name: _kinds(part) for name, part in value.items()} if isinstance(value, dict) else type(value)
