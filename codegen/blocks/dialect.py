"""The languages of a block's text: C99, and C++ with the pragmas of an HLS tool.

A line ``A //+ B`` is A in C and B in C++, indented as A; either may be empty, and the line is left out then.
"""

from collections.abc import Collection, Iterator

_MARK = "//+"


def in_c(text: str) -> str:
    """``text`` in C."""
    return "".join(f"{line}\n" for line in _lines(text, 0))


def in_cpp(text: str) -> str:
    """``text`` in C++."""
    return "".join(f"{line}\n" for line in _lines(text, 1))


def _lines(text: str, dialect: int) -> Iterator[str]:
    for line in text.splitlines():
        code, mark, other = line.partition(_MARK)
        indent = line[: len(line) - len(line.lstrip())]
        chosen = (code, indent + other.strip())[dialect].rstrip() if mark else line
        if chosen or not mark:
            yield chosen


def resolved(text: str, true: Collection[str]) -> str:
    """``text`` with the lines alone that ``#if``, ``#elif`` and ``#else`` leave of it where the names ``true`` hold."""
    kept, active, taken = [], True, False
    for line in text.splitlines():
        word, _, name = line.partition(" ")
        if word in ("#if", "#elif", "#else"):
            taken = taken and word != "#if"
            active = not taken and (word == "#else" or name in true)
            taken = taken or active
        elif word == "#endif":
            active = True
        elif active:
            kept.append(line)
    return "".join(f"{line}\n" for line in kept)
