"""The scorecard's runner: what is kept, repeated and told."""

from dataclasses import replace

import pytest

from bench.publish import ROOT, stored
from bench.scorecard.line import Line, Measured
from bench.scorecard.lines import LINES
from bench.scorecard.run import NAME, PAGE, measured, table, worse

SOURCE = "bench/publish.py"


def line(passed: bool = True, **more) -> tuple[Line, list[bool]]:
    """A line that notes each time it is measured."""
    calls: list[bool] = []

    def measure(quick: bool) -> Measured:
        calls.append(quick)
        return Measured(f"figure {len(calls)}", passed, {"times": len(calls)})

    return Line(7, "a title", "a target", "a limit.", (SOURCE,), measure, **more), calls


def test_a_result_is_kept_until_a_source_changes():
    one, calls = line()
    first = measured(one, None, False)
    assert measured(one, first, False) == first
    assert measured(one, first, True) == first
    assert calls == [False]
    other = replace(one, sources=("bench/__init__.py",))
    assert measured(other, first, False)["figure"] == "figure 2"


def test_a_quick_result_and_a_failure_are_repeated():
    one, calls = line()
    quick = measured(one, None, True)
    assert quick["command"].endswith("--only 7 --quick")
    measured(one, quick, False)
    assert calls == [True, False]
    failing, calls = line(passed=False)
    measured(failing, measured(failing, None, False), False)
    assert calls == [False, False]


def test_table_tells_what_is_missed_and_what_is_not_measured():
    failing, _ = line(passed=False)
    rows = table([measured(failing, None, False), measured(Line(8, "other", "all"), None, False)]).splitlines()
    assert rows[2:] == [
        "| 7 | a title | a target | figure 1 | **missed** | 0 |",
        "| 8 | other | all |  | not measured |  |",
        "",
        "* Line 7: a limit.",
    ]


def test_table_tells_what_was_measured_before_a_change():
    one, _ = line()
    row = table([measured(one, None, False) | {"current": False}]).splitlines()[2]
    assert "| reached, of earlier sources |" in row


@pytest.mark.parametrize(
    ("now", "before", "bad"),
    [(True, None, False), (False, None, False), (False, True, True), (False, False, False), (True, False, False)],
)
def test_a_quick_run_fails_where_a_line_was_reached_before(now, before, bad):
    assert worse({"passed": now}, None if before is None else {"passed": before}) == bad
    assert not worse({}, None)


def test_lines_are_those_of_the_page():
    assert [one.number for one in LINES] == list(range(1, 13))
    page = (ROOT / PAGE).read_text()
    assert table(stored(NAME)) in page
    missing = [place for one in LINES for place in one.sources if not (ROOT / place).exists()]
    assert missing == []


@pytest.mark.parametrize("name", ["results", "__pycache__"])
def test_what_is_written_is_no_source(name, tmp_path, monkeypatch):
    monkeypatch.setattr("bench.scorecard.line.ROOT", tmp_path)
    (tmp_path / "bench" / name).mkdir(parents=True)
    one, _ = line()
    one = replace(one, sources=("bench",))
    (tmp_path / "bench" / "a.py").write_text("1")
    key = one.key(False)
    (tmp_path / "bench" / name / "b.py").write_text("2")
    assert one.key(False) == key
    (tmp_path / "bench" / "a.py").write_text("3")
    assert one.key(False) != key


def test_a_link_is_no_source(tmp_path, monkeypatch):
    monkeypatch.setattr("bench.scorecard.line.ROOT", tmp_path)
    for name in ("hdl", "bench"):
        (tmp_path / name).mkdir()
    (tmp_path / "CHANGELOG.md").write_text("1")
    (tmp_path / "hdl" / "CHANGELOG.md").symlink_to(tmp_path / "CHANGELOG.md")
    one, _ = line()
    one = replace(one, sources=("hdl",))
    key = one.key(False)
    (tmp_path / "CHANGELOG.md").write_text("2")
    assert one.key(False) == key
