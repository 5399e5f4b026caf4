"""Initial contents of memories: out of the Verilog, into files for ``$readmemh``."""

import re
from dataclasses import dataclass

_MODULE = re.compile(r"^module (?P<module>\w+)\(.*?^endmodule", re.DOTALL | re.MULTILINE)
_BLOCK = re.compile(
    r"""
    ^\ \ initial\ begin\n
    (?P<words>(?:\ {4}(?P<memory>\w+)\[0\]\ =\ .*\n)(?:\ {4}(?P=memory)\[\d+\]\ =\ .*\n)*)
    \ \ end\n
    """,
    re.MULTILINE | re.VERBOSE,
)
_WORD = re.compile(r"\[(\d+)\] = (\d+)'(?:h([0-9a-f]+)|d(\d+));")
"""Address, bits and value of a word; yosys writes words of 32 bits in decimal."""


@dataclass(frozen=True, slots=True)
class Image:
    """Initial contents of the memory ``memory`` of the module ``module``: unsigned ``words`` of ``bits``, in order."""

    module: str
    memory: str
    bits: int
    words: tuple[int, ...]

    @property
    def file(self) -> str:
        """Name of the file; other memories have others."""
        return f"{self.module}.{self.memory}.hex"

    @property
    def facts(self) -> dict[str, str | int]:
        """Everything but the words, for the sidecar."""
        return {
            "file": self.file,
            "module": self.module,
            "memory": self.memory,
            "words": len(self.words),
            "bits": self.bits,
            "format": "hexadecimal, two's complement where signed, one word a line from address 0",
        }


def extract(verilog: str) -> tuple[str, list[Image]]:
    """``verilog`` of plain names with every initialised memory read from a file; and the files' contents.

    Memories of nothing but zeros stay as they are: they have no data and only avoid unknown values in simulators.
    Raises ``ValueError`` for words that yosys does not write.
    """
    images: list[Image] = []

    def module(match: re.Match[str]) -> str:
        name = match["module"]

        def block(match: re.Match[str]) -> str:
            image = _image(name, match["memory"], match["words"])
            if not any(image.words):
                return match[0]
            images.append(image)
            return f'  initial $readmemh("{image.file}", {match["memory"]});\n'

        return _BLOCK.sub(block, match[0])

    return _MODULE.sub(module, verilog), images


def _image(module: str, memory: str, block: str) -> Image:
    found = _WORD.findall(block)
    if [int(address) for address, *_ in found] != list(range(block.count("\n"))):
        raise ValueError(f"images: the words of {module}, {memory} are not understood")
    return Image(module, memory, int(found[0][1]), tuple(int(w, 16) if w else int(d) for *_, w, d in found))
