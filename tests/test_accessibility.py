"""Faults that are planted in a page are found, and nothing else."""

from pathlib import Path

from tests.accessibility import faults_at_all_widths
from tests.browser import browser

PAGE = """<!DOCTYPE html><html lang="en"><head><title>A page</title><style>
.pale {{ color: #bbb; }} @media (max-width: 640px) {{ .narrow {{ color: #bbb; }} }}</style></head>
<body><main><h1>A page</h1><p class="{kind}">Some words</p><button>{name}</button></main></body></html>"""


def test_planted_faults_are_found(tmp_path: Path) -> None:
    expected = {
        ("", "Play"): [],
        ("pale", ""): ["button-name (critical)", "color-contrast (serious)"],
        ("narrow", "Play"): ["color-contrast (serious)"],
    }
    with browser(tmp_path) as tab:
        for (kind, name), names in expected.items():
            (tmp_path / "page.html").write_text(PAGE.format(kind=kind, name=name))
            tab.open(tmp_path / "page.html")
            assert [fault.partition(":")[0] for fault in faults_at_all_widths(tab)] == names
