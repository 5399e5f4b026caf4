"""Runs the commands of docs/first_hour.md and writes their answers below them.

``python -m bench.contacts.first_hour`` runs them one after the other in a fresh folder.
Of a command that warns, only the warnings stand on the page: they say what to do next.
"""

from __future__ import annotations

import io
import re
import shlex
import tempfile
from collections.abc import Callable
from contextlib import chdir, redirect_stderr, redirect_stdout
from unittest import mock

from bench.publish import ROOT
from tfra.cli.main import main as tfra

PAGE = ROOT / "docs" / "first_hour.md"
BLOCK = re.compile(r"^```console\n\$ (?P<command>(?:[^\n]*\\\n)*[^\n]*)\n(?P<answer>.*?)^```$", re.M | re.S)


def answer(command: str) -> str:
    """What a command prints in the current folder, lines as they are in a terminal of 100 columns."""
    words = shlex.split(command.replace("\\\n", " "))
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), mock.patch.dict("os.environ", {"COLUMNS": "100"}):
        tfra(words[1:])
    return err.getvalue() or out.getvalue()


def executed(text: str, run: Callable[[str], str] = answer) -> str:
    """The page ``text`` with the answers of its commands, run one after the other in a fresh folder."""
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        return BLOCK.sub(lambda found: f"```console\n$ {found['command']}\n{run(found['command'])}```", text)


if __name__ == "__main__":
    PAGE.write_text(executed(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
