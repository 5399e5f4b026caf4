"""The C driver with the methods of the Python driver, by ctypes: one sequence of calls tries both."""

import ctypes
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from ctypes import POINTER, Structure, c_bool, c_int, c_int32, c_size_t, c_uint32, c_void_p
from pathlib import Path
from types import ModuleType
from typing import Any

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow")
STRICT = (*STRICT, "-Wcast-qual", "-Wstrict-prototypes", "-Wmissing-prototypes")
SOURCES = ("tfra_driver.c", "tfra_frame.c")
SHIM = Path(__file__).with_name("library.c")

READ32 = ctypes.CFUNCTYPE(c_int, c_void_p, c_uint32, POINTER(c_uint32))
WRITE32 = ctypes.CFUNCTYPE(c_int, c_void_p, c_uint32, c_uint32)
ARGUMENT = 2
REASONS = {
    1: "bus",
    3: "no TFRA core",
    4: "register map",
    5: "another configuration",
    6: "did not become",
    7: "stopped core",
    8: "no coefficients",
    9: "coefficients arrived with another checksum",
    10: "arrived with another checksum",
    11: "bytes",
    12: "format or bits",
    13: "soft reset",
}
"""What the Python driver says, by the codes of C."""


def structure(name: str, **members: Any) -> Any:
    return type(name, (Structure,), {"_fields_": list(members.items())})


CBus = structure("CBus", read32=READ32, write32=WRITE32, user=c_void_p, polls=c_uint32)
CDevice = structure("CDevice", bus=CBus, config=c_void_p)
CLoad = structure("CLoad", count=c_uint32, crc=c_uint32, match=c_bool, loaded=c_bool)
CFrontEnd = structure(
    "CFrontEnd",
    **{"word_bits": c_uint32, "is_unsigned": c_bool, "invert": c_bool, "log2_average": c_uint32},
    **{"dead_band": c_uint32, "contact": c_uint32, "stuck_frames": c_uint32},
)
_COUNTERS = ("frames_in", "frames_out", "frames_dropped", "frames_saturated", "frame_cycles")
CCounters = structure("CCounters", **dict.fromkeys(_COUNTERS, c_uint32), consistent=c_bool)
CFaultyTaxel = structure("CFaultyTaxel", index=c_uint32, saturated=c_bool, out_of_range=c_bool, stuck=c_bool)
_UNSIGNED, _SIGNED = ("sequence", "user", "faults", "frame", "exponent", "sweep_index", "phi"), ("mu", "mu_x", "mu_y")
CFrame = structure(
    "CFrame",
    **dict.fromkeys(_UNSIGNED, c_uint32),
    **dict.fromkeys(_SIGNED, c_int32),
    **{"resultant": c_int32 * 3, "uncertainty": c_int32, "status": c_uint32, "forces": POINTER(c_int32)},
)


def compiled(folder: Path, name: str) -> ctypes.CDLL:
    """The library of the driver in the package ``folder``, for the design ``name``."""
    shim = folder / "library.c"
    shim.write_text(SHIM.read_text().replace("DESIGN", name))
    files = [shim, *(folder / "driver" / file for file in SOURCES)]
    options = ["-shared", "-fPIC", "-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all"]
    options += [f"-I{folder}/driver", f"-I{folder}/registers"]
    subprocess.run(["gcc", *STRICT, *options, "-o", folder / "library.so", *files], check=True)
    return ctypes.CDLL(str(folder / "library.so"))


class CCore:
    """``tfra_host.Core`` in C; ``host`` is that package, for its names and exceptions."""

    def __init__(self, library: ctypes.CDLL, host: ModuleType, bus: Any, facts: Mapping[str, Any], polls: int) -> None:
        self._library, self._host, self._bus, self.polls = library, host, bus, polls
        self.failure: BaseException | None = None
        self._callbacks = CBus(READ32(self._read32), WRITE32(self._write32), None, polls)
        self._device = CDevice()
        self._call("open", ctypes.byref(self._callbacks), config(library, host, facts))

    def _read32(self, user: Any, address: int, word: Any) -> int:
        try:
            word[0] = self._bus.read32(address)
        except BaseException as error:  # a callback of C can't raise
            self.failure = error
        return int(self.failure is not None)

    def _write32(self, user: Any, address: int, word: int) -> int:
        try:
            self._bus.write32(address, word)
        except BaseException as error:
            self.failure = error
        return int(self.failure is not None)

    def _call(self, name: str, *arguments: Any) -> None:
        code = getattr(self._library, f"tfra_{name}")(ctypes.byref(self._device), *arguments)
        failure, self.failure = self.failure, None
        assert (code == 1) == (failure is not None), f"{name}: {code}, {failure}"
        if failure is not None:
            raise failure
        if code == ARGUMENT:
            raise ValueError(name)
        if code:
            raise self._host.DeviceError(REASONS[code])

    def _got(self, name: str, kind: Any, state: Any) -> Any:
        found = kind()
        self._call(name, ctypes.byref(found))
        return state(**{member: getattr(found, member) for member, _ in kind._fields_})

    def __getattr__(self, name: str) -> Any:
        """Functions that take nothing."""
        return lambda: self._call(name)

    def set_options(self, options: Iterable[str]) -> None:
        self._call("set_options", self._mask("CONTROL", options))

    def load(self, words: Sequence[int]) -> None:
        self._call("load", (c_int32 * len(words))(*words), len(words))

    def get_load(self) -> Any:
        return self._got("get_load", CLoad, self._host.Load)

    def set_front_end(self, settings: Any) -> None:
        self._call("set_front_end", ctypes.byref(CFrontEnd(*vars(settings).values())))

    def get_front_end(self) -> Any:
        return self._got("get_front_end", CFrontEnd, self._host.FrontEnd)

    def set_offsets(self, first: int, offsets: Sequence[int]) -> None:
        self._call("set_offsets", first, (c_int32 * len(offsets))(*offsets), len(offsets))

    def set_gains(self, first: int, gains: Sequence[int]) -> None:
        self._call("set_gains", first, (c_uint32 * len(gains))(*gains), len(gains))

    def get_offsets(self, first: int, count: int) -> list[int]:
        words = (c_int32 * max(count, 0))()
        self._call("get_offsets", first, words, count)
        return list(words)

    def get_gains(self, first: int, count: int) -> list[int]:
        words = (c_uint32 * max(count, 0))()
        self._call("get_gains", first, words, count)
        return list(words)

    def set_repairs(self, repairs: Mapping[int, Mapping[int, float]]) -> None:
        self._library.tfra_repair_target.restype = self._library.tfra_repair_source.restype = c_uint32
        words = []
        for target, sources in repairs.items():
            words.append(self._library.tfra_repair_target(target))
            words += [self._library.tfra_repair_source(t, round(w * 65536)) for t, w in sources.items()]
        self._call("set_repairs", (c_uint32 * len(words))(*words), len(words))

    def tare(self, log2_frames: int) -> None:
        self._call("tare", c_uint32(log2_frames))

    def wait_tare(self) -> None:
        self._call("wait_tare", self.polls)

    def get_counters(self) -> Any:
        return self._got("get_counters", CCounters, self._host.Counters)

    def get_errors(self) -> frozenset[str]:
        return self._names("get_errors", "ERRORS")

    def clear_errors(self, errors: Iterable[str] | None = None) -> None:
        self._call("clear_errors", self._mask("ERRORS", self._host.ERRORS if errors is None else errors))

    def get_faulty_taxel(self) -> Any:
        return self._got("get_faulty_taxel", CFaultyTaxel, self._host.FaultyTaxel)

    def set_stale_timeout(self, cycles: int) -> None:
        self._call("set_stale_timeout", c_uint32(cycles))

    def enable_interrupts(self, events: Iterable[str]) -> None:
        self._call("enable_interrupts", self._mask("INTERRUPT_ENABLE", events))

    def get_interrupts(self) -> frozenset[str]:
        return self._names("get_interrupts", "INTERRUPT_STATUS")

    def acknowledge_interrupts(self, events: Iterable[str] | None = None) -> None:
        chosen = self._host.EVENTS if events is None else events
        self._call("acknowledge_interrupts", self._mask("INTERRUPT_STATUS", chosen))

    def _mask(self, register: str, names: Iterable[str]) -> int:
        fields = self._host.registers.REGISTERS[register]["fields"]
        return sum(1 << fields[name][0] for name in names)

    def _names(self, function: str, register: str) -> frozenset[str]:
        found = c_uint32()
        self._call(function, ctypes.byref(found))
        names: frozenset[str] = self._host.registers.names(register, found.value)
        return names


def config(library: ctypes.CDLL, host: ModuleType, facts: Mapping[str, Any]) -> c_void_p:
    """The ``tfra_config_t`` of the library's design, with the hash of ``facts``."""
    library.design.restype = c_void_p
    return c_void_p(library.design(c_uint32(int(host.design_hash(facts), 16) & 0xFFFFFFFF)))


def parsed(library: ctypes.CDLL, host: ModuleType, facts: Mapping[str, Any], data: bytes, tuser: int = 0) -> Any:
    """The integers of a frame by ``tfra_parse_frame``; ``forces`` is None, or a pointer into ``beats``."""
    beats, frame = (c_uint32 * (len(data) // 4)).from_buffer_copy(data), CFrame()
    arguments = (config(library, host, facts), beats, c_size_t(len(beats)), c_uint32(tuser), ctypes.byref(frame))
    if code := library.tfra_parse_frame(*arguments):
        raise host.DeviceError(REASONS[code])
    frame.beats = beats
    return frame
