"""The C of a design, built once into the cache by the system's compiler, and called on arrays: the engine ``c``."""

import ctypes
import os
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from tfra.codegen.blocks.result import gathered
from tfra.codegen.c.files import core
from tfra.codegen.c.memory import ram_bytes, size_of
from tfra.codegen.c.shaped import arguments, shaped
from tfra.codegen.sidecar.build import sidecar
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.runtime.digest import digest
from tfra.runtime.errors import InputError
from tfra.runtime.processes import ToolError, complaint, running
from tfra.runtime.scratch import scratch, temporary
from tfra.runtime.store import Files, cache_directory, cached

COMPILER = "gcc"
INSTALL = "apt-get install gcc"
_WIDTH = ("-mprefer-vector-width=256",) if os.uname().machine == "x86_64" else ()
"""Rows of coefficients are short: longer vectors leave more of them over."""
_FLAGS = ("-std=c99", "-O3", "-march=native", *_WIDTH, "-ffp-contract=off", "-shared", "-fPIC")
_LIBRARIES = ("-lm",)
_LIBRARY = "core.so"

_COPIED = Template("""
static int64_t *copied(const ${name}_result *result, int64_t *words)
{
    int place = 0;
$gather
    return words + place;
}
""")

_CALLS = Template("""\
#include "$name.h"

#include <math.h>
$copied
int64_t run(${name}_state *state, const ${name}_code *codes, int64_t frames, int64_t *words)
{
    ${name}_result result;
    for (int64_t frame = 0; frame < frames; frame++) {
        ${name}_step(state, codes + frame * ${NAME}_TAXELS, &result);
        words = copied(&result, words);
    }
    return frames;
}

int step(${name}_state *state, const double *stress, double *values)
{
    ${name}_code codes[${NAME}_TAXELS];
    ${name}_result answer, *result = &answer;
    const double top = $top;
    for (int taxel = 0; taxel < ${NAME}_TAXELS; taxel++) {
        const double code = rint(stress[taxel] / $lsb);
        if (!isfinite(code))
            return taxel + 1;
        codes[taxel] = (${name}_code)(code > top ? top : code < -top - 1 ? -top - 1 : code);
    }
    ${name}_step(state, codes, result);
    const double scale = ldexp(1, -result->exponent);
    int place = 0;
$measured
    return 0;
}
""")

SHARE = 256
"""Frames that are worth a thread."""


class Compiled:
    """The bit-accurate model of ``design``, compiled; raises ``InputError`` without a compiler."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self._code = np.dtype(f"i{size_of(design.adc.bits)}")
        self._library = loaded(library(design))
        self._run = self._function("run", None, 4)

    def _function(self, name: str, result: Any, arguments: int) -> Any:
        function = getattr(self._library, name)
        function.restype, function.argtypes = result, [ctypes.c_void_p] * arguments
        return function

    def state(self) -> Any:
        """Memory for one sequence of frames."""
        return ctypes.create_string_buffer(ram_bytes(self.design))

    def stepper(self) -> Callable[[int, int], int]:
        """A function of the addresses of a frame's stress in Pa, of doubles row by row, and of its words in SI units.

        Both are arrays of doubles, the second one as long as a result frame.  It returns 0, or the number of the first
        taxel, from 1, that is not finite; stress beyond full scale is limited.
        """
        return partial(self._function("step", ctypes.c_int, 3), self.state())

    def words(self, codes: Ints) -> Ints:
        """Result words ``(n, frame_words)`` of converter ``codes (n, rows, columns)``.

        Frames are shared among all processors that this process may use.
        """
        given = np.ascontiguousarray(codes, dtype=self._code).reshape(-1, self.design.sensor.taxels)
        words = np.empty((len(given), self.design.frame_words), dtype=np.int64)
        shares = max(1, min(len(os.sched_getaffinity(0)), -(-len(given) // SHARE)))
        parts = zip(np.array_split(given, shares), np.array_split(words, shares), strict=True)
        with ThreadPoolExecutor(shares) as pool:
            list(pool.map(lambda part: self._part(*part), parts))
        words[:, 0] = np.arange(len(words)) & ((1 << COUNTER_BITS) - 1)
        return words

    def _part(self, codes: Ints, words: Ints) -> None:
        self._run(self.state(), codes.ctypes.data, len(codes), words.ctypes.data)


class Shaped:
    """The same for many designs of few shapes, each of which is built once; of use in one thread."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self._library = _shape(shaped(design))
        self._constants, self._tables = arguments(design)

    def words(self, codes: Ints) -> Ints:
        """As :meth:`Compiled.words`, without its threads."""
        given = np.ascontiguousarray(codes, dtype=np.int32).reshape(-1, self.design.sensor.taxels)
        words = np.empty((len(given), self.design.frame_words), dtype=np.int64)
        addresses = (ctypes.c_void_p * len(self._tables))(*(table.ctypes.data for table in self._tables))
        self._library.choose(ctypes.c_void_p(self._constants.ctypes.data), addresses)
        self._library.run(
            ctypes.c_void_p(given.ctypes.data), ctypes.c_int64(len(given)), ctypes.c_void_p(words.ctypes.data)
        )
        words[:, 0] &= (1 << COUNTER_BITS) - 1
        return words


def quickest(design: Design) -> Callable[[Ints], Ints]:
    """The bit-accurate model as a function of codes, in C if there is a compiler."""
    return Shaped(design).words if shutil.which(COMPILER) else lambda codes: design.model(codes).words


@cache
def _shape(text: str) -> ctypes.CDLL:
    return loaded(built("shape", {"shape.c": text}))


def loaded(library: bytes) -> ctypes.CDLL:
    """The functions of a ``library``."""
    with scratch(temporary()) as folder:
        (folder / _LIBRARY).write_bytes(library)
        return ctypes.CDLL(str(folder / _LIBRARY))


def library(design: Design) -> bytes:
    """The library of ``design``: ``run(state, codes, frames, words)`` and ``step``; raises as :func:`built`."""
    return built(design.name, core(design, sidecar(design)) | {"calls.c": _calls(design)})


def built(name: str, texts: dict[str, str]) -> bytes:
    """The library of sources and headers, from the cache if it is there; raises ``InputError`` without a compiler."""
    if not shutil.which(COMPILER):
        raise InputError(COMPILER, "", f"the engine c needs a C compiler: {INSTALL}")
    key = digest(*texts.values(), *_FLAGS, _machine())
    return cached(cache_directory() / f"build-{name}-c-{key}", lambda: _compile(texts))[_LIBRARY]


def _calls(design: Design) -> str:
    return _CALLS.substitute(
        name=design.name,
        NAME=design.name.upper(),
        copied=copied(design),
        top=(1 << (design.adc.bits - 1)) - 1,
        lsb=repr(design.adc.lsb),
        measured=gathered(design, si=True),
    )


def copied(design: Design) -> str:
    """The C of a function that copies a result to words, and returns where they end."""
    return _COPIED.substitute(name=design.name, gather=gathered(design))


def _machine() -> str:
    """The compiler, and what the processor can do."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return f"{os.uname().machine} {next((line for line in lines if line.startswith(('flags', 'Features'))), '')}"


def _compile(texts: dict[str, str]) -> Files:
    with scratch(temporary()) as folder:
        for name, text in texts.items():
            (folder / name).write_text(text)
        sources = [name for name in texts if name.endswith(".c")]
        with running([COMPILER, *_FLAGS, "-o", _LIBRARY, *sources, *_LIBRARIES], folder) as process:
            output, _ = process.communicate()
        if process.returncode:
            raise ToolError(complaint(COMPILER, process.returncode, output))
        return {_LIBRARY: (folder / _LIBRARY).read_bytes()}
