"""Whatever a description holds: tables, or one short line."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings

from tests.recordings.test_frames import mutated, result_or_line
from tfra.codegen.config.read import load
from tfra.runtime.errors import LONGEST_VALUE, InputError, quoted, shortened
from tfra.runtime.inputs import opened, read_toml
from tfra.runtime.ownership import is_as_written

EXAMPLE = (Path(__file__).parents[2] / "examples" / "hertz_40x20.toml").read_bytes()

WRONG = [
    ("a = 1\na = 2", "line 2: Cannot overwrite a value"),
    ("a = " + "9" * 5000, "is not valid TOML"),
    ("a = 0x" + "f" * 99_999, "a: a whole number of at most 64 bits is needed"),
    ("[b]\na = [1, {c = 9223372036854775808}]", "b.a#2.c: a whole number of at most 64 bits is needed"),
    ("a" + ".a" * 30, "is not valid TOML: a key has more than 20 dots"),
    ("a = " + "[" * 9999, "is not valid TOML"),
    ("a = '" + "x" * 2_000_000, "at most 2,000,000 bytes of TOML are supported"),
    ("a = 1\0", "line 1, column 6: "),
    ("a = 2,8\n", "line 1, column 6: Expected newline or end of document after a statement: numbers have decimal"),
    ('"' + "k" * 100_000 + '" = 1\n"' + "k" * 100_000 + '" = 2', "line 2: Cannot overwrite a value"),
]


@pytest.mark.parametrize(("text", "line"), WRONG, ids=[str(n) for n in range(len(WRONG))])
def test_wrong_text(tmp_path: Path, text: str, line: str) -> None:
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_toml(path)
    assert str(caught.value).removeprefix(f"{path}: ").startswith(line)
    assert len(str(caught.value)) <= len(str(path)) + 300


def test_dots_and_marks_that_are_fine(tmp_path: Path) -> None:
    numbers = ", ".join(["0.5"] * 1000)
    (tmp_path / "a.toml").write_bytes(b"\xef\xbb\xbf# " + b"." * 100 + b"\n" + f"a = [{numbers}]\n".encode())
    assert read_toml(tmp_path / "a.toml") == {"a": [0.5] * 1000}


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(mutated(EXAMPLE))
def test_mutated_descriptions(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.toml").write_bytes(data)
    result_or_line(lambda: load(tmp_path / "a.toml"), tmp_path / "a.toml")


@pytest.mark.parametrize(
    ("make", "kind"),
    [(os.mkfifo, "a pipe"), (lambda path: os.symlink("/dev/null", path), "a device")],
)
def test_what_is_no_file_is_not_opened(tmp_path: Path, make: Callable[[Path], None], kind: str) -> None:
    make(tmp_path / "a")
    with pytest.raises(InputError, match=rf"a: is not a regular file but {kind}$"), opened(tmp_path / "a"):
        pass


def test_a_name_with_a_nul(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"b: cannot be read: no file has a NUL in its name$"), opened(Path("a\0b")):
        pass
    assert not is_as_written(tmp_path / "a\0b", "frames")


def test_a_file_that_becomes_a_pipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between a look at the file and opening it."""
    os.mkfifo(tmp_path / "a")
    (tmp_path / "b").touch()
    looked_at = os.stat(tmp_path / "b")
    monkeypatch.setattr("os.stat", lambda path: looked_at)
    with pytest.raises(InputError, match=r"a: is not a regular file but a pipe$"), opened(tmp_path / "a"):
        pass


# Long lines


def test_shortened() -> None:
    assert shortened("x" * LONGEST_VALUE) == "x" * LONGEST_VALUE
    assert shortened("x" * 61) == "x" * 43 + "… (61 characters)"
    assert shortened("\n" * 1_000_000).endswith("… (1,000,000 characters)")
    assert shortened("\U0001f600\x00" * 30).isprintable()
    for text in ("x" * 61, "\n" * 1_000_000, "\x00" * 60):
        assert len(shortened(text)) == LONGEST_VALUE


def test_quoted() -> None:
    assert quoted("a") == "'a'"
    assert quoted([1, 2]) == "[1, 2]"
    assert quoted(1 << 99_999) == "a number of thousands of digits"


def test_long_parts_of_a_line() -> None:
    line = str(InputError("f" * 300, "k" * 1_000_000, "r" * 1_000_000))
    assert line.startswith("f" * 300 + ": kkk")
    assert len(line) <= 600
