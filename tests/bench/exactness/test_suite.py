"""Which tests can notice a change, and in what order they are asked."""

from __future__ import annotations

from pathlib import Path

from bench.exactness.mutants import table
from bench.exactness.suite import PACKAGES, Copy, nearest, reached, texts
from bench.publish import ROOT

TREE = {
    "hdl/__init__.py": "",
    "hdl/lib/divider.py": "from tfra.model.numbers import length\n",
    "hdl/lib/streams.py": "",
    "model/numbers.py": "",
    "tests/hdl/lib/test_divider.py": "from tfra.hdl.lib.divider import Divider\n",
    "tests/hdl/lib/test_streams.py": "from tfra.hdl.lib import (\n    streams,\n)\n",
    "tests/model/test_divider.py": "from tests.hdl.lib import test_divider\n",
    "tests/cli/test_main.py": 'run([sys.executable, "-m", "tfra.hdl.lib.divider"])\n',
    "tfra/__init__.py": "from tfra.model.numbers import length\n",
    "tfra/engines.py": "",
    "tests/tfra/test_pages.py": "import tfra\n",
    "tests/tfra/test_engines.py": "from tfra import engines\n",
    "tests/test_all.py": "",
}


def reaching(file):
    return [test for test, files in reached(TREE).items() if file in files]


def test_tests_that_reach_a_file():
    assert reaching("hdl/lib/streams.py") == ["tests/hdl/lib/test_streams.py"]
    through_others = ["tests/hdl/lib/test_divider.py", "tests/model/test_divider.py", "tests/cli/test_main.py"]
    assert reaching("hdl/lib/divider.py") == through_others
    library = ["tests/tfra/test_pages.py", "tests/tfra/test_engines.py"]
    assert reaching("model/numbers.py") == through_others + library
    assert reaching("tfra/__init__.py") == library
    assert reaching("tfra/engines.py") == library[1:]


def test_every_package_is_known():
    links = {file.name for file in (ROOT / "tfra").iterdir() if file.is_symlink()}
    assert links == {*PACKAGES, "examples"}


def test_a_copy_imports_its_own_files(tmp_path: Path):
    copy = Copy(tmp_path)
    copy.write("tfra/result.py", texts(copy.root)["tfra/result.py"] + "\nCHANGED = 1\n")
    names = ["tfra", "tfra.engines", "tfra.result", *(f"tfra.{package}" for package in PACKAGES), "bench", "tests"]
    seen = [f"import {name}\nprint({name}.__file__)\n" for name in names]
    copy.write("tests/where.py", "".join(seen) + "print(tfra.result.CHANGED)\n")
    code, output = copy.run(["tests.where"], 60)
    *files, changed = output.split()
    assert (code, changed, len(files)) == (0, "1", len(names))
    assert all(Path(file).resolve().is_relative_to(copy.root.resolve()) for file in files)


def test_the_nearest_come_first():
    tests = list(reached(TREE))
    divider = ["tests/hdl/lib/test_divider.py", "tests/model/test_divider.py", "tests/hdl/lib/test_streams.py"]
    assert nearest("hdl/lib/divider.py", tests) == divider
    assert nearest("hdl/serial/new/core.py", tests) == ["tests/test_all.py"]
    assert nearest("hdl/serial/new/core.py", tests[:-1]) == []


def test_table():
    def line(file, status, tier=""):
        return {"file": file, "status": status, "tier": tier}

    record = [
        line("hdl/lib/a.py", "killed", "short"),
        line("hdl/lib/a.py", "killed", "long"),
        line("hdl/lib/b.py", "survived"),
        line("model/fixed/c.py", "killed", "short"),
        line("model/fixed/c.py", "equivalent"),
        line("model/fixed/d.py", "broken", "short"),
    ]
    lines = table(record).splitlines()
    assert lines[0].startswith("4 mutants of 3 files; 2 more are left out")
    assert lines[0].endswith("`make test` notices 2 of the 3 that all tests notice, 67%.")
    assert table([*record, line("hdl/lib/a.py", "open")]).splitlines()[2:] == lines[2:]
    assert lines[-3:] == ["| `hdl/lib` | 3 | 2 | 1 |", "| `model/fixed` | 1 | 1 | 1 |", "| all | 4 | 3 | 2 |"]
