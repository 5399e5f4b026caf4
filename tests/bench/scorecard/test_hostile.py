"""Line 10 notices readers that fail, stop or die, cores that reach beyond their arrays, and tests that fail."""

import os
import re
import signal
from pathlib import Path
from typing import Any

import pytest

from bench.scorecard.hostile import fuzz, measure, readers, sanitizers
from bench.scorecard.hostile.mutate import of
from bench.scorecard.hostile.reader import Prepared, Reader
from bench.scorecard.words.drawn import drawn
from tfra.runtime.errors import InputError

SEEDS = [b"a = 1\nb = 2\n"]


def planted(monkeypatch: pytest.MonkeyPatch, read: Any) -> dict[str, Any]:
    """What 400 inputs of a reader find."""

    def make(folder: Path) -> Prepared:
        return of(SEEDS), read

    monkeypatch.setitem(readers.READERS, "planted", Reader(make, 1))
    monkeypatch.setattr(fuzz, "limited", lambda: None)
    return fuzz.tried("planted", 0, 400)


def test_a_reader_with_a_key_error_is_found_and_its_input_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    def read(data: bytes) -> None:
        seen.append(data)
        if b"b" not in data:
            {}[data]
        if data.startswith(b"a = 1\n"):
            raise InputError("f", "a", "no")

    found = planted(monkeypatch, read)
    ((number, count, said),) = found["findings"]
    assert said.startswith("KeyError at test_hostile.py:")
    assert count == found["outcome"]["found"] == sum(b"b" not in data for data in seen) > 0
    assert found["outcome"]["refused"] > 0 < found["outcome"]["read"]
    assert b"b" not in seen[number]
    first = list(seen)
    seen.clear()
    planted(monkeypatch, read)
    assert seen == first


def test_a_refusal_in_two_lines_is_found() -> None:
    def read(data: bytes) -> None:
        raise ValueError("a\nb")

    assert fuzz.complaint(read, b"", (ValueError,)) == "not a line: 'a\\nb'"
    assert fuzz.complaint(lambda data: None, b"", (ValueError,)) is None


def test_a_reader_that_does_not_end_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(number: int, frame: object) -> None:
        raise fuzz.Slow("slow")

    monkeypatch.setattr(fuzz, "SECONDS", 0.05)
    before = signal.signal(signal.SIGPROF, stop)
    try:
        said = fuzz.complaint(lambda data: re.fullmatch("(a+)+b", "a" * 40), b"", (InputError,))
    finally:
        signal.signal(signal.SIGPROF, before)
    assert said
    assert said.startswith("Slow at ")


def test_a_process_that_dies_is_a_finding_and_the_next_goes_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    script = tmp_path / "dies.py"
    script.write_text(
        "import os, struct, sys\n"
        "_, first, end, path = sys.argv[1:]\n"
        "if int(first) <= 5: open(path, 'r+b').write(struct.pack('<q', 5)); os._exit(7)\n"
        'print(\'{"outcome": {"read": 4}, "findings": []}\')\n'
    )
    monkeypatch.setattr(fuzz, "WORKER", (str(script),))
    found = fuzz.watched("r", 0, 10)
    assert found["outcome"] == {"read": 4, "found": 1}
    assert [finding[:2] for finding in found["findings"]] == [[5, 1]]
    assert "ended with 7" in found["findings"][0][2]


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.long)])
def test_an_access_beyond_an_array_is_reported(compiler: str) -> None:
    design = next(iter(drawn(1, 1))).design
    codes = sanitizers.frames(design, 3)
    texts = sanitizers.sources(design)
    right = sanitizers.compared(design, compiler, texts, codes)
    assert (right["report"], right["differ"]) == ("", 0)
    assert int(right["compared"]) > 0
    wrong = texts["calls.c"].replace("codes + frame *", "codes + 1 + frame *")
    found = sanitizers.compared(design, compiler, texts | {"calls.c": wrong}, codes)
    assert "heap-buffer-overflow" in str(found["report"])


def test_every_kind_of_failure_misses_the_target() -> None:
    tests = {"misuse": {"passed": 3, "not passed": 0}}
    checked = {"c": {"compared": 9, "differ": 0, "report": ""}}
    fuzzed: dict[str, dict[str, Any]] = {"r": {"outcome": {"read": 1_000_000}, "findings": []}}
    assert measure.judged(tests, checked, fuzzed, False).passed
    few = {"r": {"outcome": {"read": 9999}, "findings": []}}
    bad = {"r": {"outcome": {"read": 1_000_000}, "findings": [[1, 1, "KeyError"]]}}
    failed = {"misuse": {"passed": 3, "not passed": 1}}
    reported = {"c": {"compared": 9, "differ": 0, "report": "heap-buffer-overflow"}}
    for other in ((failed, checked, fuzzed), (tests, reported, fuzzed), (tests, checked, bad), (tests, checked, few)):
        assert not measure.judged(*other, False).passed
    for key, wrong in (("differ", 1), ("compared", 0)):
        assert not measure.judged(tests, {"c": checked["c"] | {key: wrong}}, fuzzed, False).passed


def test_tests_are_counted(tmp_path: Path) -> None:
    file = tmp_path / "test_three.py"
    file.write_text("def test_a():\n    pass\n\n\ndef test_b():\n    assert 0\n\n\ndef test_c():\n    raise OSError\n")
    assert measure.tested([os.fspath(file)]) == {"passed": 1, "not passed": 2}
