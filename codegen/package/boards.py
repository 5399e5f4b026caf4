"""Boards: the core behind a serial line, the way to a bitstream, and a program for the host."""

from __future__ import annotations

import json

import numpy as np

from tfra.codegen.package.boardtop import BAUD, Board, board_verilog
from tfra.codegen.package.contents import Contents, filled
from tfra.hdl.uart.bridge import CODE_BYTES, WORD_BYTES, coefficient_bytes
from tfra.model.cover.scenes import contact_codes

BOARDS = {
    "ecp5": Board("ulx3s", 25_000_000, inverted=False),
    "ice40": Board("icebreaker", 12_000_000, inverted=True),
    "portable": Board("ulx3s", 25_000_000, inverted=False),
}
"""By the target of a design."""

_FILES = {"ulx3s": ("ulx3s.lpf", "build.sh"), "icebreaker": ("icebreaker.pcf", "build.sh")}

_CHECKED, _SEED = 4, 2
"""Simulated contacts that the host's program compares, and their seed."""


def boards(contents: Contents) -> dict[str, str]:
    """``boards/BOARD``: top module, constraints, a script that builds it; ``boards/talk.py`` talks to it."""
    board = BOARDS[contents.design.target]
    folder = f"boards/{board.name}"
    values = {"name": contents.name, "size": _size(contents.part.name), "images": " ".join(contents.images)}
    made = {f"{folder}/{file}": filled(f"{board.name}_{file}", values) for file in _FILES[board.name]}
    return {
        **made,
        f"{folder}/top.v": board_verilog(contents.design, board),
        "boards/talk.py": filled("talk.py.txt", {"name": contents.name, "baud": BAUD}),
        "boards/line.json": json.dumps(_line(contents)) + "\n",
    }


def _size(part: str) -> str:
    """The size of an ECP5, in thousands of lookup tables; that of the smallest board for others."""
    return part.split("-")[1] if part.startswith("ecp5-") else "25"


def _line(contents: Contents) -> dict[str, object]:
    """What the host's program needs: sizes of words in bytes, and frames with the words that are due for them."""
    design = contents.design
    codes = contact_codes(design, _CHECKED, _SEED)
    words, loaded = design.model(codes).words, contents.core.loaded
    return {
        "code_bytes": CODE_BYTES,
        "word_bytes": WORD_BYTES,
        "coefficient_bytes": 0 if loaded is None else coefficient_bytes(design),
        "coefficient_bits": design.coefficient_word,
        "codes": codes.reshape(len(codes), -1).tolist(),
        "words": np.asarray(words).tolist(),
    }
