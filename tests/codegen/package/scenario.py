"""What a host does with a core, and what it must see: the same calls for every driver, on the world of ``bridge``."""

import zlib
from collections.abc import Callable, Sequence
from typing import Any

import pytest

TARE, GAIN = (5, -3), 40000
"""Words of the frames that are averaged for offsets; a gain that is not the one after power-up."""


def play(world: Any) -> None:
    """Everything; raises ``AssertionError`` or a driver's exception for what is wrong."""
    other = {**world.facts, "configuration_sha256": "0123456789abcdef" * 4}
    with pytest.raises(world.host.DeviceError, match="another configuration"):
        world.core(other)
    core = world.core(world.facts)
    of_frames = (load, settings, tables, tare, frames, faults, half_in, stopped)
    for part in (load, contacts) if "skin" in world.facts else of_frames:
        part(world, core)


def refused() -> Any:
    """An argument is outside its limits."""
    return pytest.raises(ValueError, match=r"\w")


def load(world: Any, core: Any) -> None:
    if not world.coefficients:
        with refused():
            core.load([1])
        return
    with pytest.raises(world.host.DeviceError, match="no coefficients"):
        core.start()
    with refused():
        core.load(world.coefficients[:-1])
    crc = zlib.crc32(b"".join(word.to_bytes(4, "little", signed=True) for word in world.coefficients))
    world.damage(0x80)
    with pytest.raises(world.host.DeviceError, match="coefficients arrived with another checksum"):
        core.load(world.coefficients)
    assert core.get_errors() == {"load_checksum"}
    assert core.get_interrupts() == {"error", "loaded"}
    core.clear_errors()
    for _ in range(2):
        core.acknowledge_interrupts()
        core.load(world.coefficients)
        assert core.get_load() == world.host.Load(len(world.coefficients), crc, match=True, loaded=True)
        assert core.get_errors() == set()
        assert core.get_interrupts() == {"loaded"}
    core.acknowledge_interrupts(["loaded"])


def settings(world: Any, core: Any) -> None:
    bits = world.facts["adc"]["bits"]
    first = world.host.FrontEnd(bits)
    assert core.get_front_end() == first
    limits = [("word_bits", 7), ("word_bits", 17), ("log2_average", 7), ("dead_band", 1 << 16), ("contact", 1 << 16)]
    for name, value in [*limits, ("stuck_frames", 256)]:
        with refused():
            core.set_front_end(world.host.FrontEnd(**{"word_bits": bits, name: value}))
    assert core.get_front_end() == first
    other = world.host.FrontEnd(9, True, True, 6, 40000, 50000, 200)
    core.set_front_end(other)
    assert core.get_front_end() == other
    words = [world.read32(address) for address in (0xA0, 0xA8, 0xAC)]
    assert words == [9 | 1 << 5 | 1 << 6 | 6 << 7, 40000 | 50000 << 16, 200]
    core.set_front_end(first)


def tables(world: Any, core: Any) -> None:
    taxels = world.facts["sensor"]["rows"] * world.facts["sensor"]["columns"]
    assert core.get_offsets(0, taxels) == [0] * taxels
    assert core.get_gains(0, taxels) == [world.host.UNITY_GAIN] * taxels
    offsets = [-131072, 131071, *range(-1, taxels - 3)]
    core.set_offsets(0, offsets)
    core.set_gains(1, [0, 131071])
    assert core.get_offsets(0, taxels) == offsets
    assert core.get_offsets(1, 2) == offsets[1:3]
    assert core.get_gains(0, 4) == [world.host.UNITY_GAIN, 0, 131071, world.host.UNITY_GAIN]
    world.damage(0xB8)
    with pytest.raises(world.host.DeviceError, match="arrived with another checksum"):
        core.set_offsets(0, offsets)
    wrong: list[Callable[[], None]] = [
        lambda: core.set_offsets(taxels - 1, [0, 0]),
        lambda: core.set_offsets(0, [131072]),
        lambda: core.set_gains(0, [131072]),
        lambda: core.get_gains(taxels, 1),
        lambda: core.set_repairs({taxels: {0: 1.0}}),
        lambda: core.set_repairs({0: dict.fromkeys(range(taxels), 0.1)} | {1: {taxels: 1.0}}),
    ]
    for call in wrong:
        with refused():
            call()
    repairs = {1: {0: 0.5, 2: -0.25}, 2: {1: 1.0}}
    core.set_repairs(repairs)
    assert core.get_repairs() == world.host.repair_words(repairs)
    assert world.read32(0xB0) == 5
    core.set_repairs({})
    assert world.read32(0xB0) == 0
    core.set_offsets(0, [0] * taxels)
    core.set_gains(0, [world.host.UNITY_GAIN] * taxels)


def tare(world: Any, core: Any) -> None:
    """The mean of equal frames is each of them, and gives no result."""
    taxels, bits = world.facts["sensor"]["rows"] * world.facts["sensor"]["columns"], world.facts["adc"]["bits"]
    words = [TARE[taxel % 2] for taxel in range(taxels)]
    with refused():
        core.tare(7)
    core.clear_counters()
    core.tare(1)
    polls, core.polls = core.polls, 3
    with pytest.raises(world.host.DeviceError, match="did not become"):
        core.wait_tare()
    core.polls = polls
    world.send(words, 0)
    world.send(words, 1)
    core.wait_tare()
    core.stop()
    assert core.get_offsets(0, taxels) == [word << 17 - bits for word in words]
    assert core.get_counters().frames_out == 0
    core.set_offsets(0, [0] * taxels)


def frames(world: Any, core: Any) -> None:
    """Every frame gives its result, one of them without forces at the taxels; counters count, interrupts come."""
    core.clear_counters()
    core.acknowledge_interrupts()
    core.set_options(["taxel_forces"])
    core.enable_interrupts(["frame"])
    assert not world.interrupt()
    core.start()
    for call in (lambda: core.load(world.coefficients or [0]), lambda: core.set_gains(0, [1]), lambda: core.tare(0)):
        with pytest.raises((world.host.DeviceError, ValueError)):
            call()
    for number, (words, result) in enumerate(zip(world.frames[:-1], world.results, strict=False)):
        whole = number != 1
        core.set_options(["taxel_forces"] if whole else [])
        world.send(words, 100 + number)
        frame = world.host.parse_frame(world.facts, world.receive())
        expected = by_field(world.facts, result)
        if not whole:
            del expected["forces"]
        assert dict(frame.words) == expected
        assert (frame.user, frame.faults) == (100 + number, frozenset())
        assert world.interrupt()
        assert core.get_interrupts() == {"frame"}
        core.acknowledge_interrupts(["frame"])
        assert not world.interrupt()
    counters, many = core.get_counters(), len(world.frames) - 1
    assert (counters.frames_in, counters.frames_out, counters.frames_dropped) == (many, many, 0)
    assert counters.frame_cycles >= len(world.frames[0])
    core.wait_idle()


def by_field(facts: dict[str, Any], words: Sequence[int]) -> dict[str, tuple[int, ...]]:
    return {f["name"]: tuple(words[f["start"] : f["start"] + f["count"]]) for f in facts["result"]["fields"]}


def faults(world: Any, core: Any) -> None:
    """Bad frames, a gap in the numbers, a simulated error, and a stream that stopped."""
    before = core.get_counters()
    core.set_options(["taxel_forces", "check_sequence"])
    core.enable_interrupts(["error"])
    core.stop()
    core.start()
    assert world.read32(0x40) == 0b1001001, "a stop keeps the options"
    assert core.get_errors() == set()
    world.send(world.frames[0][: world.taxels_per_beat], 7)
    world.send([*world.frames[0], *[0] * world.taxels_per_beat], 8)
    assert world.interrupt(20)
    assert core.get_errors() == {"short_frame", "long_frame"}
    core.clear_errors(["short_frame"])
    assert core.get_errors() == {"long_frame"}
    after = core.get_counters()
    assert after.frames_dropped == before.frames_dropped + 2
    assert (after.frames_in, after.frames_out) == (before.frames_in, before.frames_out)
    core.clear_errors()
    core.simulate_error()
    assert core.get_errors() == {"simulated"}
    world.send(world.frames[-1], 10)
    frame = world.host.parse_frame(world.facts, world.receive())
    assert dict(frame.words) == by_field(world.facts, world.results[-1])
    assert frame.faults == {"simulated", "sequence_gap"}
    assert core.get_errors() == {"simulated", "sequence_gap"}
    core.clear_errors()
    core.set_stale_timeout(50)
    world.interrupt(120)
    assert core.get_errors() == {"stale"}
    core.set_stale_timeout(0)
    core.clear_errors()
    core.acknowledge_interrupts()
    assert not world.interrupt()
    core.clear_counters()
    assert core.get_counters() == world.host.Counters(0, 0, 0, 0, 0)


def contacts(world: Any, core: Any) -> None:
    """Every frame has the contacts of the settings before it, one of them without forces at the taxels."""
    core.start()
    for number, (words, settings, expected) in enumerate(zip(world.frames, *world.results, strict=True)):
        whole = number != 1
        core.set_contacts(world.host.ContactSettings(*settings))
        core.set_options(["taxel_forces"] if whole else [])
        world.send(words, 100 + number)
        frame = world.host.parse_contacts(world.facts, world.receive())
        assert (frame.user, frame.faults) == (100 + number, frozenset())
        assert frame.dropped == expected[-1][3]
        by_name = [by_field(world.facts, record) for record in expected if record[6]]
        for contact, known in zip(frame.contacts, by_name, strict=True):
            window = {f"window.{name}": words for name, words in contact.window.words.items()}
            if not whole:
                del known["window.forces"]
            assert {name: (word,) for name, word in contact.words.items()} | window == known
    core.wait_idle()


def half_in(world: Any, core: Any) -> None:
    """A stop waits for a source that is slower than the bus: gains that are written then leave its frame as it was."""
    taxels = len(world.frames[0])
    core.set_options(["taxel_forces"])
    world.send_slowly(world.frames[0], 7, cycles=200)
    core.stop()
    core.set_gains(0, [GAIN] * taxels)
    frame = world.host.parse_frame(world.facts, world.receive())
    assert {**frame.words, "frame": 0} == {**by_field(world.facts, world.results[0]), "frame": 0}, "a frame half in"
    core.set_gains(0, [world.host.UNITY_GAIN] * taxels)
    core.start()


def stopped(world: Any, core: Any) -> None:
    core.stop()
    assert core.get_errors() == set()
    core.soft_reset()
    if world.coefficients:
        assert not core.get_load().loaded
        with pytest.raises(world.host.DeviceError, match="no coefficients"):
            core.start()
