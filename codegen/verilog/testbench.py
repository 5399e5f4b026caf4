"""A testbench in plain Verilog: a few frames, the expected words, stalls on both ports."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from amaranth import Shape

from tfra.codegen.verilog.header import frame_lines
from tfra.hdl.cores import microarchitecture
from tfra.hdl.skin.payloads import setting_ports
from tfra.model.arrays import Ints
from tfra.model.cover.scenes import contact_codes, directed_codes
from tfra.model.fixed.design import Design
from tfra.model.skin.records import records, result_shape
from tfra.model.skin.scenes import recorded as skin_frames
from tfra.model.skin.skin import Skin

CONTACTS = 4
"""Simulated contacts; every directed frame comes after them."""

SEED = 1

_LINE = 10
"""Words in a line of the file."""

_LOAD = "  //@load\n"
"""The end of a template's lines that only a core with a ``load`` port needs."""

_STORE = Template("""\
  task $kind(input integer count, input [$top:0] words);
    integer place;
    for (place = count - 1; place >= 0; place = place - 1) begin
      $memory[${kind}_count] = words[$slot * place +: $bits];
      ${kind}_count = ${kind}_count + 1;
    end
  endtask""")


def recorded(design: Design) -> Ints:
    """Codes of the frames that testbenches send, ``(frames, taxels)``."""
    codes = np.concatenate([contact_codes(design, CONTACTS, SEED), directed_codes(design)])
    return codes.reshape(len(codes), -1)


def patience(array: Design | Skin, interval: int) -> int:
    """Cycles without a word after which a core hangs whose frames are ``interval`` cycles apart."""
    searching = 40 * array.sensor.taxels if isinstance(array, Skin) else 0  # cycles between two contacts, at most
    return 20 * interval + searching + 1000


def testbench(array: Design | Skin, facts: dict[str, Any]) -> str:
    """Text of the testbench ``NAME_tb``; ``facts`` are those of the sidecar."""
    _, bits = result_shape(array)
    if isinstance(array, Skin):
        design, codes = array.window, skin_frames(array)
        words = records(array, codes, design.model.words)
        given = [*calls("code", codes.ravel(), array.adc.bits), *calls("result", words.ravel(), bits)]
        ports = setting_ports(array).items()
        settings = [f" .{name}({Shape.cast(port.shape).width}'d{port.init})," for name, port in ports]
    else:
        design, codes = array, recorded(array)
        words = design.model(codes).words
        given, settings = [*_frames(design, codes, words)], []
    values = {
        "name": array.name,
        "frames": len(codes),
        "words": words.size,
        "frame": words.shape[1],
        "taxel_top": array.adc.bits - 1,
        "word_top": bits - 1,
        "last_taxel": codes.size - 1,
        "last_word": words.size - 1,
        "settings": "".join(settings),
        "patience": patience(array, facts["interval_cycles"]),
        "formats": "\n".join(f"// {line}" for line in frame_lines(facts)),
        "store_code": store("code", "taxels", array.adc.bits),
        "store_result": store("result", "expected", bits),
        "given": "\n".join(given),
    }
    return filled("testbench.v.txt", design, values)


def filled(file: str, design: Design, values: dict[str, object]) -> str:
    """The template ``file`` with ``values`` and coefficients, or without the lines for these."""
    lines = Path(__file__).with_name(file).read_text().splitlines(keepends=True)
    loaded = microarchitecture(design).loaded
    if loaded is None:
        lines = [line for line in lines if not line.endswith(_LOAD)]
    else:
        bits = design.coefficient_word
        values |= {
            "load_top": bits - 1,
            "last_load": len(loaded) - 1,
            "store_coefficient": store("coefficient", "coefficients", bits),
            "coefficients": "\n".join(calls("coefficient", loaded, bits)),
        }
    return Template("".join(lines).replace(_LOAD, "\n")).substitute(values)


def store(kind: str, memory: str, bits: int) -> str:
    """A task that stores a line of words."""
    slot = 4 * _digits(bits)
    return _STORE.substitute(kind=kind, memory=memory, bits=bits, slot=slot, top=slot * _LINE - 1)


def _frames(design: Design, codes: Ints, words: Ints) -> Iterator[str]:
    for number, (given, expected) in enumerate(zip(codes, words, strict=True)):
        yield f"      // frame {number}, {'a contact' if number < CONTACTS else 'a corner case'}"
        yield from calls("code", given, design.adc.bits)
        yield from calls("result", expected, design.word_bits)


def calls(kind: str, words: Iterable[int], bits: int) -> Iterator[str]:
    """Calls of the task ``kind`` with a line of ``words`` each."""
    digits, size = hex_words(words, bits).split(), 4 * _digits(bits) * _LINE
    for start in range(0, len(digits), _LINE):
        line = digits[start : start + _LINE]
        yield f"      {kind}({len(line)}, {size}'h{'_'.join(line)});"


def _digits(bits: int) -> int:
    return -(-bits // 4)


def hex_words(words: Iterable[int], bits: int) -> str:
    """Text for ``$readmemh``: two's complement words of ``bits``, one a line."""
    digits, mask = _digits(bits), (1 << bits) - 1
    return "".join(f"{int(word) & mask:0{digits}x}\n" for word in words)
