"""The C driver with the methods of the Python driver, by ctypes: one sequence of calls tries both."""

import ctypes
import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import POINTER, Structure, byref, c_bool, c_int, c_int32, c_uint32, c_void_p
from dataclasses import fields
from functools import partial
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
}
"""What the Python driver says, by the codes of C."""


class CBus(Structure):
    _fields_ = (("read32", READ32), ("write32", WRITE32), ("user", c_void_p), ("polls", c_uint32))


class CDevice(Structure):
    _fields_ = (("bus", CBus), ("config", c_void_p))


def structure(state: Any) -> Any:
    """The structure of C with the members of a class of Python."""
    members = [(field.name, c_bool if field.type is bool else c_uint32) for field in fields(state)]
    return type(state.__name__, (Structure,), {"_fields_": members})


STATES = {
    "get_load": "Load",
    "get_front_end": "FrontEnd",
    "get_contacts": "ContactSettings",
    "get_counters": "Counters",
    "get_faulty_taxel": "FaultyTaxel",
}
"""Functions that give a structure, of this name in Python."""
FIELDS = {
    "set_options": "CONTROL",
    "clear_errors": "ERRORS",
    "enable_interrupts": "INTERRUPT_ENABLE",
    "acknowledge_interrupts": "INTERRUPT_STATUS",
}
"""Functions that take a word with names of fields of this register."""
GIVEN = {"get_errors": "ERRORS", "get_interrupts": "INTERRUPT_STATUS"}
"""Functions that give one."""
TABLES = {"offsets": c_int32, "gains": c_uint32}
"""Words of tables."""


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
        library.design.restype = c_void_p
        design = library.design(c_uint32(int(host.design_hash(facts), 16) & 0xFFFFFFFF))
        self._call("open", byref(self._callbacks), c_void_p(design))

    def _read32(self, user: Any, address: int, word: Any) -> int:
        return self._tried(lambda: word.__setitem__(0, self._bus.read32(address)))

    def _write32(self, user: Any, address: int, word: int) -> int:
        return self._tried(lambda: self._bus.write32(address, word))

    def _tried(self, access: Callable[[], None]) -> int:
        try:
            access()
        except BaseException as error:  # a callback of C can't raise
            self.failure = error
        return int(self.failure is not None)

    def _call(self, name: str, *arguments: Any) -> None:
        code = getattr(self._library, f"tfra_{name}")(byref(self._device), *arguments)
        failure, self.failure = self.failure, None
        assert (code == 1) == (failure is not None), f"{name}: {code}, {failure}"
        if failure is not None:
            raise failure
        if code == ARGUMENT:
            raise ValueError(name)
        if code:
            raise self._host.DeviceError(REASONS[code])

    def __getattr__(self, name: str) -> Any:
        """The function ``name``, by what it takes and gives; all others take nothing or a number."""
        action, _, noun = name.partition("_")
        if name in STATES:
            return partial(self._state, name, getattr(self._host, STATES[name]))
        if name in FIELDS:
            return partial(self._choose, name, FIELDS[name])
        if name in GIVEN:
            return partial(self._names, name, GIVEN[name])
        if noun in TABLES:
            return partial(self._set if action == "set" else self._get, name, TABLES[noun])
        return lambda *numbers: self._call(name, *map(c_uint32, numbers))

    def _state(self, name: str, kind: Any) -> Any:
        found = structure(kind)()
        self._call(name, byref(found))
        return kind(*(getattr(found, field.name) for field in fields(kind)))

    def _choose(self, name: str, register: str, names: Iterable[str] | None = None) -> None:
        places = self._host.registers.REGISTERS[register]["fields"]
        self._call(name, sum(1 << places[each][0] for each in (places if names is None else names)))

    def _names(self, name: str, register: str) -> Any:
        found = c_uint32()
        self._call(name, byref(found))
        return self._host.registers.names(register, found.value)

    def _set(self, name: str, kind: Any, first: int, words: Sequence[int]) -> None:
        self._call(name, first, (kind * len(words))(*words), len(words))

    def _get(self, name: str, kind: Any, first: int, count: int) -> list[int]:
        words = (kind * max(count, 0))()
        self._call(name, first, words, count)
        return list(words)

    def load(self, words: Sequence[int]) -> None:
        self._call("load", (c_int32 * len(words))(*words), len(words))

    def set_front_end(self, settings: Any) -> None:
        self._settings("set_front_end", settings)

    def set_contacts(self, settings: Any) -> None:
        self._settings("set_contacts", settings)

    def _settings(self, name: str, settings: Any) -> None:
        self._call(name, byref(structure(type(settings))(*vars(settings).values())))

    def set_repairs(self, repairs: Mapping[int, Mapping[int, float]]) -> None:
        self._library.tfra_repair_target.restype = self._library.tfra_repair_source.restype = c_uint32
        words = []
        for target, sources in repairs.items():
            words.append(self._library.tfra_repair_target(target))
            words += [self._library.tfra_repair_source(t, round(w * 65536)) for t, w in sources.items()]
        self._call("set_repairs", (c_uint32 * len(words))(*words), len(words))

    def get_repairs(self) -> list[int]:
        words = (c_uint32 * 512)()
        count = c_uint32()
        self._call("get_repairs", words, len(words), byref(count))
        return words[: count.value]

    def wait_tare(self) -> None:
        self._call("wait_tare", self.polls)
