"""The report of ``tfra synth`` as facts: one JSON object."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from statistics import median_low
from typing import Any

from tfra.codegen.verilog.wrapper import module_name
from tfra.families import Target
from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.ip.wrapper import cut_through, interval, latencies, skin_interval, skin_latencies
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of
from tfra.synth.estimate import Estimate
from tfra.synth.flow import Route, Synthesis, options
from tfra.synth.tools import versions


def top_name(array: Design | Skin, *, package: bool) -> str:
    """Name of the module that is synthesised."""
    return module_name(array) if package else array.name


def median_route(routes: Sequence[Route]) -> Route:
    """The seed of median speed, the slower of the two in the middle of an even number."""
    middle = median_low(route.mhz for route in routes)
    return next(route for route in routes if route.mhz == middle)


def report(
    array: Design | Skin,
    target: Target,
    synthesis: Synthesis,
    routes: Sequence[Route],
    estimated: Estimate,
    seeds: int,
    *,
    package: bool,
    netlist: str,
    asked_mhz: float,
) -> dict[str, Any]:
    """All results, ready for JSON; complete when all ``seeds`` have been routed.

    ``netlist``: fingerprint of the Verilog; ``asked_mhz``: of place and route.
    Resources are those of place and route where it ran, else of synthesis; times are at the median frequency.
    """
    core = microarchitecture(core_of(array))
    used = {**synthesis.resources, **(median_route(routes).resources if routes else {})}
    return {
        "generator": f"tfra {version('tfra')}",
        "name": top_name(array, package=package),
        "package": package,
        "netlist": netlist,
        "complete": len(routes) == seeds,
        "seeds_wanted": seeds,
        "target": target.name,
        "architecture": asdict(core.design.architecture),
        "mac_lanes": core.lanes,
        "resources": resource_facts(target, used, estimated.total),
        "estimated_blocks": {
            block: {name: round(number) for name, number in row.items()} for block, row in estimated.blocks.items()
        },
        "mapper": synthesis.mapper,
        "cells": dict(sorted(synthesis.cells.items())),
        "clock": clock_facts(routes) | {"asked_mhz": asked_mhz} if routes else None,
        "note": target.family.timing or None,
        "timing": _timing(array, core, median_route(routes).mhz if routes else None, package=package),
        "tools": versions(target.family),
        "options": options(target.family),
    }


def _timing(array: Design | Skin, core: Microarchitecture, mhz: float | None, *, package: bool) -> dict[str, Any]:
    """Of a core, or of a frame of a skin with as many contacts as there may be."""
    if not isinstance(array, Skin):
        return timing(core, mhz, package=package)
    frame = SkinTiming.of(array, core)
    stated = {"contacts": array.choices.most, "taxels_of_a_contact": frame.taxels}
    products = array.choices.most * core.design.multiplications
    cycles = {"frame_latency": frame.frame_latency, "interval": frame.interval}
    if package:
        _, last = skin_latencies(frame)
        cycles = {"frame_latency": last, "interval": skin_interval(frame)}
    return stated | _times(cycles, mhz, products, core.lanes)


def resource_facts(
    target: Target, used: Mapping[str, int], estimated: Mapping[str, int] | None = None
) -> dict[str, dict[str, Any]]:
    """Every resource of ``target``: what is used, what the part has, its share, and the estimate."""
    facts = {}
    for name in target.resources:
        available = target.available.get(name)
        facts[name] = {
            "used": used[name],
            "available": available,
            "percent": round(100 * used[name] / available, 1) if available else None,
            "estimated": estimated[name] if estimated else None,
        }
    return facts


def clock_facts(routes: Sequence[Route]) -> dict[str, Any]:
    """Frequencies over the seeds, and the critical path of the median one."""
    speeds = [route.mhz for route in routes]
    return {
        "median_mhz": round(median_low(speeds), 2),
        "lowest_mhz": round(min(speeds), 2),
        "highest_mhz": round(max(speeds), 2),
        "seeds": [{"seed": route.seed, "mhz": round(route.mhz, 2)} for route in routes],
        "critical_path": asdict(median_route(routes).path),
    }


def timing(core: Microarchitecture, mhz: float | None, *, package: bool = False) -> dict[str, Any]:
    """Cycles of ``core`` and, at ``mhz``, times: latency to the first result word, frame latency to the last.

    With ``package`` from stream to stream, of a frame that meets an idle core, and the latency of cut-through, too.
    """
    first, last, *_ = latencies(core) if package else (core.latency, core.frame_latency)
    between = interval(core) if package else core.initiation_interval
    cycles = {"latency": first, "frame_latency": last, "interval": between}
    if package:
        cycles["cut_through"], _ = cut_through(core)
    return _times(cycles, mhz, core.design.multiplications, core.lanes)


def _times(cycles: Mapping[str, int], mhz: float | None, products: int, lanes: int) -> dict[str, Any]:
    """``cycles`` by name, their times at ``mhz``, and what the lanes do in an interval."""
    found: dict[str, Any] = {f"{name}_cycles": number for name, number in cycles.items()}
    if mhz:
        found |= {f"{name}_us": round(number / mhz, 3) for name, number in cycles.items()}
        found["frames_per_second"] = round(1e6 * mhz / cycles["interval"], 1)
    found["multiplications_per_frame"] = products
    return found | {"mac_utilisation": round(products / (lanes * cycles["interval"]), 4)}
