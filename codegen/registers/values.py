"""What the constant registers of a design say."""

import re
from importlib.metadata import version

from tfra.codegen.registers.source import register_map
from tfra.codegen.sidecar.build import sidecar
from tfra.hdl.bus.map import RegisterMap
from tfra.hdl.cores import microarchitecture
from tfra.model.estimators import ESTIMATORS
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import repair_places

ARCHITECTURES = ("parallel", "serial")
"""By their numbers in CAPABILITIES."""


def parameters(design: Design) -> dict[str, int]:
    """Values for the parameters of ``tfra.rdl``; they follow from the sidecar, and are the same for the same design."""
    facts, core = sidecar(design), microarchitecture(design)
    major, minor, patch = (int(number) for number in re.findall(r"\d+", version("tfra"))[:3])
    design_hash = int(facts["configuration_sha256"][:16], 16)
    return {
        "MAJOR": major,
        "MINOR": minor,
        "PATCH": patch,
        "HASH_LOW": design_hash & 0xFFFFFFFF,
        "HASH_HIGH": design_hash >> 32,
        "ESTIMATOR": tuple(ESTIMATORS).index(design.estimator),
        "ARCHITECTURE": ARCHITECTURES.index(design.architecture.kind),
        "LOADABLE": int(core.loaded is not None),
        "TAXEL_FORCES": int("forces" in design.result_fields),
        "ROWS": design.sensor.rows,
        "COLUMNS": design.sensor.columns,
        "TAXEL_BITS": design.adc.bits,
        "RESULT_BITS": design.word_bits,
        "COEFFICIENT_BITS": design.coefficient_word,
        "RESULT_LENGTH": design.frame_words,
        "LATENCY_CYCLES": core.latency,
        "INTERVAL_CYCLES": core.initiation_interval,
        "LOAD_LENGTH": 0 if core.loaded is None else core.loaded.size,
        "TAXELS_PER_BEAT": design.bus.taxels_per_beat,
        "REPAIR_PLACES": repair_places(design.sensor.taxels),
    }


def registers_of(design: Design) -> RegisterMap:
    """The register map with the values of a design; raises ``InputError`` without the compiler of SystemRDL."""
    return register_map(parameters(design))
