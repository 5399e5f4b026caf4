"""The house as docs/architecture.md and docs/development.md describe it: rooms, blocks, lengths, links."""

from __future__ import annotations

import ast
import inspect
import re
from graphlib import CycleError, TopologicalSorter
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.cores import microarchitecture
from tfra.hdl.parallel.learned import blocks as learned
from tfra.hdl.parallel.tfra.blocks import Blocks
from tfra.hdl.parallel.tfra.timeline import TfraTimeline
from tfra.model.choices import Architecture
from tfra.model.fixed.learned.pipeline import Stage as LearnedStage
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Stage
from tfra.model.sensor import SensorArray

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "runtime", "families", "model", "recordings", "report", "hdl", "codegen", "sim", "synth", "study", "train", "view",
    "calibrate", "paper", "tfra", "cli", "docs", "bench",
)
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]

PICTURE = "<!-- rooms -->\n"
DESIGN = TfraDesign(SensorArray(2, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4))
LEARNED = learned_design(2, 2)


def rooms() -> list[list[str]]:
    """Rooms of the picture, floor by floor from the ground; those on one floor don't know each other."""
    text = (ROOT / "docs" / "architecture.md").read_text()
    lines = text.partition(PICTURE)[2].partition("```\n")[2].partition("```")[0].splitlines()
    floors = [re.findall(r"[a-z_]+(?:/[a-z_]+)*(?=/?(?:\s|$))", line.partition("  ─")[0]) for line in lines]
    return [floor for floor in reversed(floors) if floor]


def modules() -> dict[str, Path]:
    files = (file for package in PACKAGES for file in (ROOT / package).rglob("*.py"))
    return {".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file for file in files}


def imports(file: Path, known: dict[str, Path]) -> set[str]:
    """Modules of ours that ``file`` imports, anywhere in it but for type checkers alone."""
    found = set()
    tree = ast.parse(file.read_text())
    typing = {id(n) for node in ast.walk(tree) if is_typing(node) for n in ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and id(node) not in typing:
            for name in node.names:
                candidates = map(in_room, (f"{node.module}.{name.name}", node.module))
                found |= set(islice((module for module in candidates if module in known), 1))
    return found


def in_room(module: str) -> str:
    """Where a module of ours lies: the folder ``tfra`` has links to the other rooms."""
    inside = module.removeprefix("tfra.")
    return inside if inside.split(".")[0] in PACKAGES else module


def is_typing(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def room_of(module: str, known: list[str]) -> str:
    path = module.replace(".", "/")
    return max((room for room in known if f"{path}/".startswith(f"{room}/")), key=len)


def upward(module: str, imported: str, floors: list[list[str]]) -> bool:
    """Whether the import goes to a room on the same floor or above."""
    order = {room: height for height, floor in enumerate(floors) for room in floor}
    here, there = (room_of(name, list(order)) for name in (module, imported))
    return here != there and order[there] >= order[here]


def test_arrows_go_one_way() -> None:
    known, floors = modules(), rooms()
    assert len(floors) > 8
    wrong = [
        f"{module} imports {imported}"
        for module, file in known.items()
        for imported in imports(file, known)
        if upward(module, imported, floors)
    ]
    assert wrong == []


@pytest.mark.parametrize(
    ("module", "imported"),
    [
        ("model.tfra", "model.fixed.design"),
        ("hdl.serial.core", "hdl.parallel.payloads"),
        ("hdl.parallel.gain", "hdl.parallel.tfra.forces"),
        ("sim.run", "synth.gates"),
        ("codegen.config", "cli.main"),
        ("tfra.engines", "cli.common"),
        ("sim.run", "tfra.engines"),
        ("paper.report", "bench.publish"),
        ("cli.main", "docs.tools.pages"),
    ],
)
def test_an_arrow_the_other_way_is_noticed(module: str, imported: str) -> None:
    assert upward(module, imported, rooms())
    assert not upward(imported, module, rooms()) or module.startswith("hdl.serial")


def test_no_circle_of_files() -> None:
    known = modules()
    graph = {module: imports(file, known) - {module} for module, file in known.items()}
    packages = {module for module, file in known.items() if file.name == "__init__.py"}
    tuple(TopologicalSorter({module: found - packages for module, found in graph.items()}).static_order())
    with pytest.raises(CycleError):
        tuple(TopologicalSorter({**graph, "model.sensor": {"model.tfra"}}).static_order())


def test_files_and_functions_are_short() -> None:
    long = [f"{file}: {n} lines" for file in modules().values() if (n := len(file.read_text().splitlines())) > 400]
    for file in modules().values():
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                length = (node.end_lineno or 0) - node.lineno + 1
                long += [f"{file}: {node.name}: {length} lines"] if length > 60 else []
    assert long == []


def block_tables() -> list[list[tuple[str, ...]]]:
    """Rows of the guide's tables of blocks: TFRA's, those of the learned estimator, those of a skin."""
    guide = (ROOT / "docs" / "development.md").read_text()
    row = re.compile(r"^\| `(\w+)` \| `(hdl/\S+)` \| `(model/\S+)` \| `(tests/\S+)` \|$", re.MULTILINE)
    return [found for part in guide.split("\n\n") if (found := row.findall(part))]


def test_every_block_has_its_places() -> None:
    """Model, stage, gateware, probe, timeline, test and rows of every block, by the table of the guide."""
    rows, *_ = block_tables()
    blocks = dict(Blocks(DESIGN))
    picture = (ROOT / "docs" / "architecture.md").read_text()
    assert set(re.findall(r"^\| `(\w+)`", picture, re.MULTILINE)) == set(blocks)
    watched = [probe.stage for probe in microarchitecture(DESIGN).probes]
    check_places(rows, blocks, watched, set(Stage), {"fold", Stage.SCALING})
    stated = {name.partition(".")[0] for name in TfraTimeline.stated}
    assert [name for name in blocks if name not in stated] == ["fold", "matvec", "angle"]
    assert [*watched, Stage.SCALING] == list(Stage)


def test_every_block_of_the_learned_estimator_has_its_places() -> None:
    _, rows, _ = block_tables()
    blocks = dict(learned.Blocks(LEARNED))
    picture = (ROOT / "docs" / "learned.md").read_text().partition("## The parallel core")[2]
    assert set(re.findall(r"^\| `(\w+)`", picture, re.MULTILINE)) >= set(blocks) - {"normaliser", "fold"}
    watched = [probe.stage for probe in microarchitecture(LEARNED).probes]
    check_places(rows, blocks, watched, {*LearnedStage, "forces"}, {"fold", "forces", LearnedStage.WORDS})
    assert [*watched, LearnedStage.WORDS] == list(LearnedStage)


def test_every_block_of_a_skin_has_its_places() -> None:
    """Those of the unit that have a model; pages, forks and queues have none."""
    _, _, rows = block_tables()
    unit = (ROOT / "hdl" / "skin" / "unit.py").read_text()
    built = dict.fromkeys(re.findall(r"m\.submodules\.(\w+) = \w+ = [A-Z]\w+\(", unit))
    assert {row[0] for row in rows} == built.keys() - {"codes", "heights"}
    for name, *files in rows:
        assert all((ROOT / file).exists() for file in files), name
        assert files[0] == f"hdl/skin/{name}.py"


def check_places(
    rows: list[tuple[str, ...]], blocks: dict[str, Any], watched: list[str], stages: set[str], unwatched: set[str]
) -> None:
    """Files of every block, in the order of the blocks; a stage and a probe, or one of ``unwatched``."""
    assert [row[0] for row in rows] == list(blocks)
    for name, gateware, model, test in rows:
        assert Path(inspect.getfile(type(blocks[name]))).resolve() == ROOT / gateware, name
        assert (ROOT / model).exists(), name
        assert (ROOT / test).exists(), name
        assert name == "fold" or name in stages, name
        assert name in watched or name in unwatched, name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_paths_lead_somewhere(page: Path) -> None:
    text = page.read_text()
    links = [link for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text) if not re.match(r"[a-z]+:", link)]
    assert [link for link in links if not (page.parent / link).exists()] == []
    roots = "|".join((*PACKAGES, "tests", "docs", "examples"))
    paths = re.findall(rf"`((?:{roots})/[\w/.-]+)`", text)
    assert [path for path in paths if not (ROOT / path).exists() and "NAME" not in path] == []
