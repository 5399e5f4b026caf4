"""What HLS tools ask of a source, checked in its text."""

import re
from collections.abc import Iterator, Mapping

from tfra.codegen.hls.loops import Block, Call, Choice, Function, cycles, functions

_BANNED = {
    "floating point": r"\b(?:double|float|half)\b",
    "pointer to pointer": r"\*\s*(?:const\s*)?\*|\*\w+\[\w*\][,)]",
    "heap": r"\b(?:new|delete|malloc|calloc|free|std::\w+)\b",
    "jump": r"\b(?:goto|setjmp|longjmp)\b",
    "virtual": r"\b(?:virtual|typeid|throw|try)\b",
}


def broken(firmware: Mapping[str, str], top: str, values: Mapping[str, int]) -> list[str]:
    """The rules that the files ``firmware`` break, whose only function for others is ``top``."""
    text = re.sub(r"//.*", "", "\n".join(firmware.values()))
    found = functions(text)
    complaints = [f"{rule}: {hit[0]}" for rule, pattern in _BANNED.items() for hit in re.finditer(pattern, text)]
    open_to_others = re.findall(r"^(?!static|template|typedef|struct|#|\}|\{)\w[\w ]*?(\w+)\([^;{]*\)\n\{", text, re.M)
    if open_to_others != [top]:
        complaints.append(f"tops: {open_to_others}")
    if circle := _recursive(found):
        return [*complaints, f"recursion: {circle}"]
    try:
        cycles(top, found, values)
    except ValueError as error:
        complaints.append(str(error))
    unused = set(found) - {name for function in found.values() for name in _called(function.body)} - {top}
    complaints += [f"unused: {name}" for name in sorted(unused)]
    for name, function in found.items():
        if any("DATAFLOW" in pragma for pragma in function.body.pragmas):
            complaints += _channels(name, text, found)
    return complaints


def _called(part: Block | Choice | Call) -> Iterator[str]:
    match part:
        case Call():
            yield part.name
        case Choice():
            for way in part.ways:
                yield from _called(way)
        case Block():
            for inner in part.parts:
                yield from _called(inner)


def _recursive(found: Mapping[str, Function]) -> str:
    """A function that calls itself, directly or not."""
    calls = {name: set(_called(function.body)) & set(found) for name, function in found.items()}
    for name in found:
        reached, more = set[str](), calls[name]
        while more - reached:
            reached |= more
            more = set().union(*(calls[one] for one in reached))
        if name in reached:
            return name
    return ""


def _channels(region: str, text: str, found: Mapping[str, Function]) -> Iterator[str]:
    """Complaints of what is between the processes of a region: one writes, one after it reads."""
    (body,) = re.findall(rf"^.* {region}\([^{{;]*\)\n\{{\n(.*?)^\}}", text, re.M | re.S)
    local = re.findall(r"^    \w+ (\w+)(?:\[\w+\])?;", body, re.M)
    calls = re.findall(r"^    (\w+)\((.*?)\);", body, re.M | re.S)
    for name in local:
        roles = []
        for process, given in calls:
            parameters = found[process].parameters.split(", ")
            for argument, parameter in zip(re.split(r",\s*", given), parameters, strict=True):
                if argument.lstrip("&") == name:
                    roles.append("reads" if parameter.startswith("const ") else "writes")
        if roles != ["writes", "reads"]:
            yield f"channel {region}.{name}: {roles}"
