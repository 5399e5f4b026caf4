"""The bridge: SLIP both ways, frames that are dropped whole, and a core behind it against the model."""

import random
from typing import Any

import pytest
from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.uart.line import framed, frames, little_endian
from tests.marks import STALLS, long
from tfra.hdl.cores import microarchitecture
from tfra.hdl.uart.bridge import Bridge, coefficient_bytes
from tfra.hdl.uart.slip import END, ESC, Decoder, Encoder
from tfra.model.choices import SERIAL, Architecture, Search
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.sim.harness import apart, flowing, play, run

SENSOR = SensorArray(2, 2, 4e-3, 4e-3, 3e-3)
DESIGN = TfraDesign(SENSOR, search=Search(7), architecture=Architecture(4))
SERIAL_DESIGN = TfraDesign(SENSOR, search=Search(3), architecture=SERIAL)
TAXELS = SENSOR.taxels


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_encoded_frames_are_read_as_slip(stall_in: Any, stall_out: Any) -> None:
    rng = random.Random(3)
    sent = [bytes(rng.choice((END, ESC, 0, 0xDC, 0xDD, 7)) for _ in range(n)) for n in (1, 5, 2, 9)]
    payloads = [{"byte": byte, "last": place == len(one) - 1} for one in sent for place, byte in enumerate(one)]
    line = b"".join(map(framed, sent))
    record = run(Encoder(), {"i": payloads}, {"o": len(line)}, stall_in=stall_in, stall_out=stall_out)
    assert bytes(record.values["o"]) == line
    assert frames(line) == sent


@given(st.lists(st.binary(max_size=9), max_size=5))
@settings(max_examples=20)
def test_decoded_frames_are_those_that_were_sent(sent: list[bytes]) -> None:
    line = b"".join(map(framed, sent))
    cycles = [*({"i.payload": byte, "i.valid": 1} for byte in line), {}]
    record = play(Decoder(), cycles, ("o.valid", "o.payload", "end", "fault"))
    parts = bytearray()
    for row in record:
        parts += bytes([row["o.payload"]]) * row["o.valid"] + b"|" * row["end"]
    assert parts == b"".join(b"|" + one + b"|" for one in sent)
    assert not any(row["fault"] for row in record)


KINDS = ("good", "short", "long", "odd", "lost", "escape", "empty")


def sent(kind: str, codes: list[int]) -> list[dict[str, Any]]:
    """Cycles of a frame at :class:`Bridge` with the fault ``kind``."""
    content = little_endian(codes, 2)
    content = {"short": content[:-2], "long": content + b"ab", "odd": content[:-1], "empty": b""}.get(kind, content)
    line = framed(content)
    cycles = []
    for place, byte in enumerate(line):
        if kind == "lost" and place == 3:
            cycles += [{"fault": 1}, {}]
            continue
        cycles += [{"i.payload": byte, "i.valid": 1}, {}]
    if kind == "escape":
        cycles[2:2] = [{"i.payload": ESC, "i.valid": 1}, {}, {"i.payload": 7, "i.valid": 1}, {}]
    return cycles


@given(st.lists(st.sampled_from(KINDS), max_size=8), st.integers(0, 2**31))
@settings(max_examples=25)
def test_bad_frames_are_dropped_whole(kinds: list[str], seed: int) -> None:
    """What follows them is as it was sent, and each is reported."""
    rng, cycles, expected = random.Random(seed), [], []
    for kind in kinds:
        codes = [rng.randrange(-(1 << 13), 1 << 13) for _ in range(TAXELS)]
        cycles += sent(kind, codes) + [{}] * (2 * TAXELS + 4)
        expected += codes if kind == "good" else []
    cycles = [{"taxel.ready": 1, **cycle} for cycle in cycles]
    record = play(Bridge(DESIGN), cycles, ("taxel.valid", "taxel.payload", "dropped"))
    assert [row["taxel.payload"] for row in record if row["taxel.valid"]] == expected
    assert sum(row["dropped"] for row in record) == sum(kind not in ("good", "empty") for kind in kinds)


def test_a_frame_is_dropped_while_another_waits() -> None:
    first, second, third = ([n + 100 * number for n in range(TAXELS)] for number in range(3))
    rest = [{}] * 20
    late = [{"taxel.ready": 1, **cycle} for cycle in [*rest, *sent("good", third), *rest]]
    cycles = [*sent("good", first), *sent("good", second), *late]
    record = play(Bridge(DESIGN), cycles, ("taxel.valid", "taxel.payload", "dropped"))
    taken = [row["taxel.payload"] for row in record[-len(late) :] if row["taxel.valid"]]
    assert taken == first + third
    assert sum(row["dropped"] for row in record) == 1


class Chain(wiring.Component):
    """A core behind the bridge, without the UART."""

    def __init__(self, design: Any) -> None:
        self._design = design
        super().__init__({"i": In(stream.Signature(8)), "o": Out(stream.Signature(8))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.bridge = bridge = Bridge(self._design)
        m.submodules.core = core = microarchitecture(self._design).build()
        m.d.comb += [bridge.i.payload.eq(self.i.payload), bridge.i.valid.eq(self.i.valid), self.i.ready.eq(1)]
        for name in core.signature.members:
            connect(m, getattr(bridge, name), getattr(core, name))
        connect(m, bridge.o, flipped(self.o))
        return m


@pytest.mark.parametrize("design", [*long(DESIGN), SERIAL_DESIGN], ids=["parallel", "serial"])
def test_a_core_behind_the_line_gives_the_models_words(design: TfraDesign) -> None:
    codes = contact_codes(design, 2, 1)
    loaded = microarchitecture(design).loaded
    start = b"" if loaded is None else framed(little_endian(loaded, coefficient_bytes(design)))
    line = start + framed(little_endian(codes[0].ravel(), 2)) + framed(b"12345")
    expected = little_endian(design.model(codes[:1]).words.ravel(), 4)
    # Bytes are apart, as on a line.
    record = run(Chain(design), {"i": list(line)}, {"o": len(framed(expected))}, stall_in=apart(flowing, 2))
    assert frames(bytes(record.values["o"])) == [expected]
