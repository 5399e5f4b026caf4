"""Boards: the core behind a serial line, the way to a bitstream, and a program for the host."""

import json

import numpy as np

from tfra.codegen.package.boardtop import BAUD, board_verilog
from tfra.codegen.package.contents import Contents, fill
from tfra.hdl.uart.bridge import CODE_BYTES, WORD_BYTES, coefficient_bytes
from tfra.model.cover.scenes import contact_codes

_CHECKED, _SEED = 4, 2
"""Simulated contacts that the host's program compares, and their seed."""


def boards(contents: Contents) -> dict[str, str]:
    """``boards/BOARD``: top module, constraints, a script that builds it; ``boards/talk.py`` talks to it."""
    board = contents.part.target.family.board
    if board is None:
        return {}
    folder = f"boards/{board.name}"
    size = contents.part.target.part.rpartition("-")[2]
    values = {"name": contents.name, "size": size, "images": " ".join(contents.images)}
    return {
        **{f"{folder}/{file}": fill(f"{board.name}_{file}", values) for file in board.files},
        f"{folder}/top.v": board_verilog(contents.design, board),
        "boards/talk.py": fill("talk.py.txt", {"name": contents.name, "baud": BAUD}),
        "boards/line.json": json.dumps(_line(contents)) + "\n",
    }


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
