"""A core on a bus: settings, tables, coefficients, errors, counters."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from .registers import (
    CODES,
    CONSTANTS,
    ERRORS,
    EVENTS,
    LIMITS,
    OPTIONS,
    REGISTERS,
    Bus,
    ContactSettings,
    Counters,
    DeviceError,
    FaultyTaxel,
    FrontEnd,
    Load,
    crc32,
    design_hash,
    names,
    of_names,
    packed,
    part,
    signed,
)

_COUNTERS = ("frames_in", "frames_out", "frames_dropped", "frames_saturated", "frame_cycles")


class Core:
    """A core on a ``bus``; ``facts`` is its sidecar.  Waits end after ``polls`` reads.

    All methods raise ``DeviceError`` for what the core does not do, and ``ValueError`` for arguments that are outside
    their limits; these write nothing.
    """

    def __init__(self, bus: Bus, facts: Mapping[str, Any], polls: int = 100_000) -> None:
        self._bus, self.facts, self.polls = bus, facts, polls
        self.taxels: int = facts["taxel"]["transfers_per_frame"]
        if self._read("ID") != REGISTERS["ID"]["reset"]:
            raise DeviceError("no TFRA core is at this address")
        if self._get("VERSION", "map") != REGISTERS["VERSION"]["reset"] >> REGISTERS["VERSION"]["fields"]["map"][0]:
            raise DeviceError("the core has another version of the register map")
        if f"{self._read('CONFIG_HASH_HIGH'):08x}{self._read('CONFIG_HASH_LOW'):08x}" != design_hash(facts):
            raise DeviceError("the core was generated from another configuration")

    def start(self) -> None:
        """Start to take frames."""
        if not self._get("STATUS", "loaded"):
            raise DeviceError("the core has no coefficients yet")
        self._control(run=1)

    def stop(self) -> None:
        """Stop, and wait until the last frame is wholly in; take results meanwhile, or :meth:`soft_reset`."""
        self._control()
        self._wait("STATUS", "running", 0)

    def wait_idle(self) -> None:
        """Wait until no frame is in the core and all results were taken."""
        self._wait("STATUS", "busy", 0)

    def soft_reset(self) -> None:
        """Reset and stop the core; coefficients have to be loaded again, settings and tables stay."""
        self._control(soft_reset=1)

    def set_options(self, options: Iterable[str]) -> None:
        """Switch on ``options``, of OPTIONS, and the others off."""
        chosen = of_names("CONTROL", options, OPTIONS)
        self._write("CONTROL", chosen | packed("CONTROL", run=self._get("CONTROL", "run")))

    def load(self, words: Sequence[int]) -> None:
        """Reset the stopped core and load all coefficients: :func:`read_coefficients` of ``coefficients/load.hex``."""
        expected = self.facts["load"]["transfers"] if "load" in self.facts else 0
        if not words or len(words) != expected:
            raise ValueError(f"{expected} coefficients are needed, got {len(words)}")
        self._require_stopped()
        self.soft_reset()
        self._write("LOAD_CHECKSUM", crc32(words))
        for word in words:
            self._wait("LOAD_STATUS", "ready", 1)
            self._write("LOAD_DATA", word)
        self._wait("STATUS", "loaded", 1)
        if not self._get("LOAD_STATUS", "match"):
            raise DeviceError("coefficients arrived with another checksum")

    def get_load(self) -> Load:
        match, loaded = self._get("LOAD_STATUS", "match"), self._get("STATUS", "loaded")
        return Load(self._read("LOAD_COUNT"), self._read("LOAD_CRC"), bool(match), bool(loaded))

    def set_front_end(self, settings: FrontEnd) -> None:
        least, most = LIMITS["word_bits_least"], LIMITS["word_bits_most"]
        if not least <= settings.word_bits <= most or not 0 <= settings.log2_average <= LIMITS["log2_frames_most"]:
            raise ValueError(f"{settings}: words have {least} to {most} bits, and log2_average is 0 to 6")
        numbers = {name: int(getattr(settings, name)) for name in REGISTERS["FRONT_END"]["fields"]}
        front_end, stuck = packed("FRONT_END", **numbers), packed("STUCK", frames=settings.stuck_frames)
        thresholds = packed("THRESHOLDS", dead_band=settings.dead_band, contact=settings.contact)
        self._require_stopped()
        for name, word in (("FRONT_END", front_end), ("THRESHOLDS", thresholds), ("STUCK", stuck)):
            self._write(name, word)

    def get_front_end(self) -> FrontEnd:
        fields: dict[str, Any] = {**self._fields("FRONT_END"), **self._fields("THRESHOLDS")}
        fields.update({name: bool(fields[name]) for name in ("is_unsigned", "invert")})
        return FrontEnd(**fields, stuck_frames=self._get("STUCK", "frames"))

    def set_contacts(self, settings: ContactSettings) -> None:
        """Set how contacts on a skin are told apart; they may change at any time."""
        most, one, gap = (LIMITS[name] for name in ("contacts_most", "unity_threshold", "gap_most"))
        if not (1 <= settings.most <= most and 1 <= settings.threshold <= one and 0 <= settings.gap <= gap):
            raise ValueError(f"{settings}: most is 1 to {most}, threshold 1 to {one}, gap 0 to {gap}")
        numbers = {name: getattr(settings, name) for name in REGISTERS["CONTACTS"]["fields"]}
        self._write("CONTACTS", packed("CONTACTS", **numbers))

    def get_contacts(self) -> ContactSettings:
        return ContactSettings(**self._fields("CONTACTS"))

    def set_offsets(self, first: int, offsets: Sequence[int]) -> None:
        """Write offsets of taxels from ``first`` on: signed, 18 bits, in 1/2^17 of the range."""
        limit = 1 << (CODES["offset_bits"] - 1)
        self._require_taxels(first, len(offsets))
        if not all(-limit <= offset < limit for offset in offsets):
            raise ValueError(f"offsets have {CODES['offset_bits']} bits")
        self._write_table("offsets", first, offsets)

    def set_gains(self, first: int, gains: Sequence[int]) -> None:
        """Write gains: unsigned, 17 bits; UNITY_GAIN is 1, and 0 makes a taxel dead."""
        self._require_taxels(first, len(gains))
        if not all(0 <= gain < 1 << CODES["gain_bits"] for gain in gains):
            raise ValueError(f"gains have {CODES['gain_bits']} bits")
        self._write_table("gains", first, gains)

    def get_offsets(self, first: int, count: int) -> list[int]:
        self._require_taxels(first, count)
        return [signed(word, CODES["offset_bits"]) for word in self._read_table("offsets", first, count)]

    def get_gains(self, first: int, count: int) -> list[int]:
        self._require_taxels(first, count)
        return self._read_table("gains", first, count)

    def set_repairs(self, repairs: Mapping[int, Mapping[int, float]]) -> None:
        """Replace taxels by sums of others: weights by source by target; with none no taxel is repaired.

        They are carried out in this order, and a source that was repaired before has its repaired code.
        """
        words = repair_words(repairs)
        taxels = [taxel for target, sources in repairs.items() for taxel in (target, *sources)]
        places = self._get("INPUT", "repair_places")
        if len(words) > places or not all(0 <= taxel < self.taxels for taxel in taxels):
            raise ValueError(f"{places} words of taxels below {self.taxels} can be repaired")
        self._require_stopped()
        self._write("REPAIRS", 0)
        self._write_table("repairs", 0, words)
        self._write("REPAIRS", packed("REPAIRS", words=len(words)))

    def get_repairs(self) -> list[int]:
        """The words of the table that are used, as :func:`repair_words` makes them, of the stopped core."""
        self._require_stopped()
        return self._read_table("repairs", 0, self._get("REPAIRS", "words"))

    def calibrate(self, tables: Mapping[str, Any]) -> None:
        """Write the offsets, gains, repairs and the form of the words of ``tfra calibrate``'s ``front_end.json``.

        The other settings of the front end stay.
        """
        if not len(tables["gains"]) == len(tables["offsets"]) == self.taxels:
            raise ValueError(f"tables of {self.taxels} taxels are needed, got {len(tables['gains'])}")
        self.set_front_end(replace(self.get_front_end(), **tables["settings"]))
        self.set_offsets(0, tables["offsets"])
        self.set_gains(0, tables["gains"])
        repairs = tables["repairs"].items()
        self.set_repairs({int(taxel): {int(s): weight for s, weight in sources.items()} for taxel, sources in repairs})

    def tare(self, log2_frames: int) -> None:
        """Start the stopped core; 2^log2_frames frames, 0 to 6, become the offsets."""
        if not 0 <= log2_frames <= LIMITS["log2_frames_most"]:
            raise ValueError(f"log2_frames is 0 to {LIMITS['log2_frames_most']}")
        self._require_stopped()
        self._write("TARE", packed("TARE", log2_frames=log2_frames))
        self._pulse("tare")
        self.start()

    def wait_tare(self) -> None:
        """Wait for the end of :meth:`tare`."""
        self._wait("STATUS", "taring", 0)

    def get_counters(self) -> Counters:
        """All counters, of the same cycle."""
        control = self._read("CONTROL")
        self._write("CONTROL", control | packed("CONTROL", hold_counters=1))
        words = {name: self._read(name.upper()) for name in _COUNTERS}
        self._write("CONTROL", control)
        return Counters(**words)

    def clear_counters(self) -> None:
        self._pulse("clear_counters")

    def get_errors(self) -> frozenset[str]:
        """Names of the errors since they were cleared."""
        return names("ERRORS", self._read("ERRORS"))

    def clear_errors(self, errors: Iterable[str] = ERRORS) -> None:
        self._write("ERRORS", of_names("ERRORS", errors, ERRORS))

    def get_faulty_taxel(self) -> FaultyTaxel:
        """The last taxel with a fault."""
        numbers = self._fields("FAULTY_TAXEL")
        return FaultyTaxel(numbers.pop("index"), **{name: bool(flag) for name, flag in numbers.items()})

    def simulate_error(self) -> None:
        """Report the error ``simulated``, to test the way of errors to the host."""
        self._pulse("simulate_error")

    def set_stale_timeout(self, cycles: int) -> None:
        """Report ``stale`` after that many clock cycles without a frame; 0: never."""
        self._write("FRAME_TIMEOUT", packed("FRAME_TIMEOUT", cycles=cycles))

    def enable_interrupts(self, events: Iterable[str]) -> None:
        """Let ``events``, of EVENTS, raise the interrupt, and no others."""
        self._write("INTERRUPT_ENABLE", of_names("INTERRUPT_ENABLE", events, EVENTS))

    def get_interrupts(self) -> frozenset[str]:
        """Names of the events since they were acknowledged, enabled or not."""
        return names("INTERRUPT_STATUS", self._read("INTERRUPT_STATUS"))

    def acknowledge_interrupts(self, events: Iterable[str] = EVENTS) -> None:
        self._write("INTERRUPT_STATUS", of_names("INTERRUPT_STATUS", events, EVENTS))

    def _read(self, register: str) -> int:
        return self._bus.read32(REGISTERS[register]["address"])

    def _write(self, register: str, word: int) -> None:
        self._bus.write32(REGISTERS[register]["address"], word & 0xFFFFFFFF)

    def _fields(self, register: str) -> dict[str, int]:
        word = self._read(register)
        return {name: part(word, low, bits) for name, (low, bits) in REGISTERS[register]["fields"].items()}

    def _get(self, register: str, field: str) -> int:
        return self._fields(register)[field]

    def _control(self, **bits: int) -> None:
        """Write CONTROL with its options as they are, and of ``run`` and the pulses those in ``bits``."""
        fields = self._fields("CONTROL")
        self._write("CONTROL", packed("CONTROL", **{name: fields[name] for name in OPTIONS}, **bits))

    def _pulse(self, name: str) -> None:
        self._write("CONTROL", self._read("CONTROL") | packed("CONTROL", **{name: 1}))

    def _wait(self, register: str, field: str, value: int) -> None:
        if not any(self._get(register, field) == value for _ in range(self.polls)):
            raise DeviceError(f"{register}.{field} did not become {value}")

    def _require_stopped(self) -> None:
        if self._get("CONTROL", "run") or self._get("STATUS", "running"):
            raise DeviceError("settings, tables and coefficients are written to a stopped core")

    def _require_taxels(self, first: int, count: int) -> None:
        if first < 0 or count < 0 or first + count > self.taxels:
            raise ValueError(f"the core has {self.taxels} taxels")

    def _write_table(self, table: str, first: int, words: Sequence[int]) -> None:
        self._require_stopped()
        self._write("CALIBRATION_PLACE", packed("CALIBRATION_PLACE", index=first, kind=CONSTANTS["tables"][table]))
        for word in words:
            self._write("CALIBRATION_DATA", word)
        if self._read("CALIBRATION_CRC") != crc32(words):
            raise DeviceError(f"{table} arrived with another checksum")

    def _read_table(self, table: str, first: int, count: int) -> list[int]:
        words = []
        for index in range(first, first + count):
            place = packed("CALIBRATION_PLACE", index=index, kind=CONSTANTS["tables"][table])
            self._write("CALIBRATION_PLACE", place)
            words.append(self._read("CALIBRATION_VALUE"))
        return words


def read_coefficients(path: str | Path, facts: Mapping[str, Any]) -> list[int]:
    """Coefficients of ``coefficients/load.hex``, signed."""
    bits = next(port["bits"] for port in facts["ports"] if port["name"] == "load_data")
    return [signed(int(line, 16), bits) for line in Path(path).read_text(encoding="ascii").split()]


def repair_words(repairs: Mapping[int, Mapping[int, float]]) -> list[int]:
    """The table of repairs: the word of a target, then a word for each of its sources.

    Weights are rounded to 1/65536; raises ``ValueError`` outside of -2 <= weight < 2.
    """
    bits, words = CODES["repair_weight_bits"], []
    for target, sources in repairs.items():
        words.append(1 << CODES["repair_target_bit"] | target << bits)
        for taxel, weight in sources.items():
            number = round(weight * 65536)
            if signed(number, bits) != number:
                raise ValueError(f"the weight {weight} is not in -2 to 2")
            words.append(taxel << bits | number & ((1 << bits) - 1))
    return words
