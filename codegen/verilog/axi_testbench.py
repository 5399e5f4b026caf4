"""A testbench of the wrapper in plain Verilog: registers, frames of right and wrong lengths, stalls on both streams."""

import zlib
from collections.abc import Iterator, Sequence

import numpy as np

from tfra.codegen.registers.source import registers_of
from tfra.codegen.verilog.testbench import calls, filled, patience, recorded, store
from tfra.codegen.verilog.wrapper import input_bits
from tfra.hdl.bus.map import BITS, Kind, RegisterMap
from tfra.hdl.cores import microarchitecture
from tfra.hdl.front_end.ports import NUMBER
from tfra.hdl.ip.framer import FAULTS, FORMAT_PLACE, version
from tfra.hdl.ip.wrapper import interval
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import WORD, FrontEnd
from tfra.model.skin.records import results
from tfra.model.skin.scenes import recorded as skin_frames
from tfra.model.skin.skin import Skin, core_of
from tfra.model.tfra import Status

_USER = 0xA500
"""Number of the first frame."""


def axi_testbench(array: Design | Skin) -> str:
    """Text of the testbench ``NAME_axi_tb``; raises ``InputError`` without the compiler of the register map."""
    design, registers, bits = core_of(array), registers_of(array), input_bits(array)
    core = microarchitecture(design)
    codes = skin_frames(array) if isinstance(array, Skin) else recorded(array)
    words = results(array, codes)
    codes = codes.reshape(len(codes), -1)
    beats = [_beats(design, frame) for frame in codes]
    wrong = [frame for frame in (beats[0][:-1], beats[0] + beats[0][:1]) if frame]  # no short frame of one beat
    sent = [beats[0], *wrong, *beats[1:]]
    places = [0, *range(1 + len(wrong), len(sent))]
    output = _output(array, codes, words, places)
    reported = ["long_frame", *["short_frame"] * (len(wrong) > 1)]
    limited = np.concatenate(words)[:, -1] & (Status.INPUT_SATURATED | Status.OUTPUT_SATURATED)
    if limited.any() or any(frame[1] >> FAULTS["saturation"] & 1 for frame in output):
        reported.append("saturation")
    errors = {field.name: field.mask for field in registers["ERRORS"].fields}
    loaded = b"" if core.loaded is None else core.loaded.astype("<i4").tobytes()
    return filled("axi_testbench.v.txt", design, {
        **_registers(registers),
        "name": array.name,
        "frames": len(codes),
        "dropped": len(wrong),
        "reported": f"32'h{sum(errors[name] for name in reported):08x}",
        "crc": f"32'h{zlib.crc32(loaded):08x}",
        "words": sum(map(len, output)),
        "bits": bits,
        "address_top": registers.address_bits - 1,
        "last_beat": sum(map(len, sent)) - 1,
        "patience": patience(array, interval(core)),
        "store_sent": store("sent", "beats", bits + NUMBER + 1),
        "store_result": store("result", "expected", BITS + 1),
        "given": "\n".join(_given(sent, dict(zip(places, output, strict=True)), bits)),
    })


def _beats(design: Design, codes: Ints) -> list[int]:
    """Data of the beats of a frame, the first taxel of each lowest."""
    slots = design.bus.taxels_per_beat
    words = [int(code) & ((1 << WORD) - 1) for code in codes]
    starts = range(0, len(words), slots)
    return [sum(word << WORD * slot for slot, word in enumerate(words[start : start + slots])) for start in starts]


def _output(array: Design | Skin, codes: Ints, words: Sequence[Ints], sequence: Sequence[int]) -> list[Ints]:
    """Beats of each output frame, the last one marked; ``sequence``: their places among all that are sent."""
    flags = FrontEnd(array)(codes & ((1 << WORD) - 1)).flags
    faults = sum(flags[name].astype(np.int64) << FAULTS[name] for name in flags)
    output = []
    for place, fault, each in zip(sequence, np.atleast_1d(faults), words, strict=True):
        head = [place | (_USER + place) << NUMBER, fault | version(array) << FORMAT_PLACE]
        beats = np.concatenate([head, each.ravel()]) & ((1 << BITS) - 1)
        beats[-1] |= 1 << BITS
        output.append(beats)
    return output


def _given(sent: list[list[int]], output: dict[int, Ints], bits: int) -> Iterator[str]:
    for place, data in enumerate(sent):
        yield f"      // frame {place}{'' if place in output else ', of a wrong length'}"
        user, last = (_USER + place) << bits, 1 << bits + NUMBER
        yield from calls("sent", [*(user | beat for beat in data[:-1]), last | user | data[-1]], bits + NUMBER + 1)
        yield from calls("result", output.get(place, ()), BITS + 1)


def _registers(registers: RegisterMap) -> dict[str, object]:
    """Addresses by names of registers, masks by REGISTER_field, and a check of every constant."""
    checks = []
    values: dict[str, object] = {}
    for register in registers.registers:
        values[register.name] = f"{registers.address_bits}'h{register.address:02x}"
        values |= {f"{register.name}_{field.name}": f"32'h{field.mask:08x}" for field in register.fields}
        if all(field.kind is Kind.CONSTANT for field in register.fields):
            checks.append(f"    check({values[register.name]}, 32'h{register.reset:08x});  // {register.name}")
    return values | {"constants": "\n".join(checks)}
