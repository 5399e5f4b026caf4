"""The blocks in C++ for an HLS tool: counts as template arguments, pipelined loops, stages as a dataflow region."""

import re
from collections.abc import Iterable

from tfra.codegen.blocks.dialect import in_cpp
from tfra.codegen.blocks.program import blocks
from tfra.codegen.blocks.types import vectors
from tfra.codegen.hls.loops import Block, Call, Choice, Function, functions
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign

_COUNTED = re.compile(r"^(template <.*>\n)?(static \w+ (\w+)\()((?:int (?:quads|count), )+)", re.M)
_LOOP = re.compile(r"^( *)for \(.*\)( \{)?$")


def sources(design: Design) -> dict[str, str]:
    """Texts by the names of the blocks."""
    texts = {name.rpartition("/")[2]: in_cpp(text) for name, text in blocks(design).items()}
    texts["estimate"] = _dataflow(texts["estimate"], design)
    counted = {name for text in texts.values() for _, _, name, _ in _COUNTED.findall(text)}
    texts = {name: _templated(text, counted) for name, text in texts.items()}
    looping = _looping(functions("\n".join(texts.values())))
    return {name: pipelined(text, looping) for name, text in texts.items()}


def _templated(text: str, counted: set[str]) -> str:
    """Counts in front of a function's arguments become those of its template."""
    text = _COUNTED.sub(lambda m: (m[1] or f"template <{m[4].removesuffix(', ')}>\n") + m[2], text)
    calls = re.compile(rf"^(?!static )(.*)\b({'|'.join(sorted(counted))})\((\w+), ", re.M)
    text = calls.sub(r"\1\2<\3>(", text)
    return re.sub(r"\bmatvec<(\w+)>\((\w+), (\w+), ", r"matvec<\1, \2, REUSE_\3>(\3, ", text)


def _looping(found: dict[str, Function]) -> set[str]:
    """Functions with loops, of their own or of what they call; an unrolled one is none."""

    def loops(part: Block | Choice | Call) -> bool:
        match part:
            case Call():
                return part.name in found and loops(found[part.name].body)
            case Choice():
                return any(map(loops, part.ways))
        unrolled = any("UNROLL" in pragma for pragma in part.pragmas)
        return (bool(part.header) and not unrolled) or any(map(loops, part.parts))

    return {name for name, function in found.items() if loops(function.body)}


def pipelined(text: str, looping: Iterable[str] = ()) -> str:
    """A pragma for every innermost loop that has none; what calls one of the functions ``looping`` is not innermost."""
    inner = re.compile("|".join([r"\bfor \(", "#pragma HLS", *(rf"\b{name}[<(]" for name in looping)]))
    lines, place = text.splitlines(), 0
    while place < len(lines):
        found = _LOOP.match(lines[place])
        place += 1
        if not found:
            continue
        end = place
        while lines[end].startswith(f"{found[1]} "):
            end += 1
        if any(inner.search(line) for line in lines[place:end]) or _governed(lines, place - 1):
            continue
        if not found[2]:
            lines[place - 1] += " {"
            lines.insert(end, f"{found[1]}}}")
        lines.insert(place, f"{found[1]}    #pragma HLS PIPELINE II=1")
    return "\n".join(lines) + "\n"


def _governed(lines: list[str], place: int) -> bool:
    """A loop around it has a pragma already."""
    indent = len(lines[place]) - len(lines[place].lstrip())
    for line in reversed(lines[:place]):
        depth = len(line) - len(line.lstrip())
        if depth < indent and line.lstrip().startswith("for ("):
            return False
        if depth == indent and re.search(r"#pragma HLS (PIPELINE|UNROLL)", line):
            return True
        if line.startswith("{"):
            return False
    return False


def _dataflow(text: str, design: Design) -> str:
    """The last function of ``text`` as a region whose stages may work on a frame each, with the arrays between them."""
    head, start, body = text.rpartition("static void estimate(")
    arrays = {name: ("vector_t", words) for name, words in vectors(design).items()}
    if isinstance(design, TfraDesign):
        arrays["stress"] = ("code_t", design.sensor.taxels)
    lines = ["#pragma HLS DATAFLOW"]
    for name, (kind, words) in arrays.items():
        users = [place for place, line in enumerate(body.split(";\n")) if re.search(rf"state->{name}\b", line)]
        lines.append(f"{kind} {name}[{words}];")
        if (frames := users[-1] - users[0] + 1) > 2:
            lines.append(f"#pragma HLS STREAM variable={name} type=pipo depth={frames}")
    body = body.replace("state_t *state, ", "").replace("state->", "")
    return head + start + body.replace("{\n", "{\n" + "".join(f"    {line}\n" for line in lines), 1)
