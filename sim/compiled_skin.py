"""The C of a skin, built once into the cache by the system's compiler, and called on arrays."""

import ctypes
import os
from concurrent.futures import ThreadPoolExecutor
from string import Template

import numpy as np

from tfra.codegen.c.memory import size_of
from tfra.codegen.c.skin import skin_core, skin_ram_bytes
from tfra.model.arrays import Ints
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.skin.records import header_bits
from tfra.model.skin.skin import Skin
from tfra.sim.compiled import SHARE, built, copied, loaded

# A frame without contact has the record of a window of zeros.
_CALLS = Template("""\
#include "${name}_skin.h"
$copied
int64_t run(${name}_skin *skin, const ${name}_code *codes, int64_t frames, int64_t *words)
{
    static const ${name}_code none[${NAME}_TAXELS];
    ${name}_contact contacts[$most];
    int64_t records = 0;
    ${name}_skin_init(skin);
    for (int64_t frame = 0; frame < frames; frame++) {
        int found = ${name}_skin_step(skin, codes + frame * ${NAME}_SKIN_TAXELS, contacts);
        if (found == 0) {
            contacts[0] = (${name}_contact){.frame = (uint16_t)frame};
            ${name}_step(&skin->window, none, &contacts[0].window);
            found = 1;
        }
        for (int i = 0; i < found; i++) {
            const ${name}_contact *contact = contacts + i;
            const int last = i == found - 1;
            const int dropped = last ? skin->dropped : 0;
$header
            words = copied(&contact->window, words);
        }
        records += found;
    }
    return records;
}
""")

_OF_FRAME = ("last", "dropped")
"""Fields of a header that a contact doesn't have."""


class CompiledSkin:
    """The bit-accurate model of ``skin``, compiled; raises ``InputError`` without a compiler."""

    def __init__(self, skin: Skin) -> None:
        self.skin = skin
        self._code = np.dtype(f"i{size_of(skin.adc.bits)}")
        self._header = len(header_bits(skin))
        self._run = loaded(skin_library(skin)).run
        self._run.restype = ctypes.c_int64
        self._run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p]

    def words(self, codes: Ints) -> Ints:
        """Records ``(k, header + frame_words)`` of converter ``codes (n, rows, columns)``, as :func:`records` has them.

        Frames are shared among all processors that this process may use.
        """
        given = np.ascontiguousarray(codes, dtype=self._code).reshape(-1, self.skin.sensor.taxels)
        parts = np.split(given, range(SHARE, len(given), SHARE))
        with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
            found = np.concatenate(list(pool.map(self._part, parts)))
        last = found[:, list(header_bits(self.skin)).index("last")]
        found[:, 0] = (np.cumsum(last) - last) & ((1 << COUNTER_BITS) - 1)
        found[:, self._header] = np.arange(len(found)) & ((1 << COUNTER_BITS) - 1)
        return found

    def _part(self, codes: Ints) -> Ints:
        """Records of some frames, which count from 0."""
        state = ctypes.create_string_buffer(skin_ram_bytes(self.skin))
        most = len(codes) * self.skin.choices.most
        words = np.empty((most, self._header + self.skin.window.frame_words), dtype=np.int64)
        count = self._run(state, codes.ctypes.data, len(codes), words.ctypes.data)
        return words[:count].copy()


def skin_library(skin: Skin) -> bytes:
    """The library of ``skin``: ``run(state, codes, frames, words)``; raises as :func:`built`."""
    return built(skin.window.name, skin_core(skin) | {"calls.c": _calls(skin)})


def _calls(skin: Skin) -> str:
    fields = (name if name in _OF_FRAME else f"contact->{name}" for name in header_bits(skin))
    return _CALLS.substitute(
        name=skin.window.name,
        NAME=skin.window.name.upper(),
        copied=copied(skin.window),
        most=skin.choices.most,
        header="\n".join(f"            *words++ = {field};" for field in fields),
    )
