"""What axe-core finds wrong with a page: text too pale, controls without a name, and the like."""

from importlib.resources import files
from typing import Any

from tests.browser import Browser

WIDTHS = (1280, 390)
"""Pixels of windows in which pages are looked at."""

_GRAVE = ("serious", "critical")

_RUN = "axe.run(document, {resultTypes: ['violations']}).then(({violations, passes}) => ({violations, passes}))"


def faults(page: Browser) -> list[str]:
    """The serious and critical faults of the page that is shown, each with the element that has it."""
    page.evaluate(files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8") + ";0")
    found: dict[str, Any] = page.evaluate(_RUN)
    assert len(found["passes"]) > 5, "axe-core has looked at nothing"
    return [
        f"{fault['id']} ({fault['impact']}): {fault['help']}: {node['html'][:200]}"
        for fault in found["violations"]
        if fault["impact"] in _GRAVE
        for node in fault["nodes"]
    ]


def faults_at_all_widths(page: Browser) -> list[str]:
    """The faults in windows of all ``WIDTHS``, each once."""
    found: dict[str, None] = {}
    for width in WIDTHS:
        page.resize(width)
        found |= dict.fromkeys(faults(page))
    return list(found)
