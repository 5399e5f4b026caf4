"""The README's table of what was measured, from the results of the campaigns: ``python -m bench.headline``."""

from bench.parts.presets import PUBLISHED_MS
from bench.publish import ROOT, insert, stored
from tfra.codegen.config.read import load
from tfra.hdl.cores import microarchitecture


def exact() -> str:
    """How the bit-accurate model differs from the float model."""
    sensors = stored("formats")["results"]["standard"].values()
    equal, swept = (sum(row[key] for row in sensors) for key in ("equal", "swept"))
    phi, force = (max(row[key] for row in sensors) for key in ("phi_deg", "force"))
    return (
        f"integers choose the same μ as float64 in {equal / swept:.1%} of {swept:,} random contacts; "
        f"there φ is within {phi:.4f}° and a taxel's force within {force:.1e} · \\|F\\|"
    )


def verified() -> str:
    """How many words of generated Verilog were compared with the bit-accurate model."""
    reports = [report for name in ("campaign", "campaign_learned") for report in stored(name)["reports"]]
    axi = stored("axi")["records"]
    words = sum(report["compared"] for report in reports) + sum(record["words"] for record in axi)
    differ = sum(report["mismatches"] for report in reports) + sum(len(record["differences"]) for record in axi)
    return f"{words:,} result words of Verilog in Icarus and Verilator, alone and behind AXI: {differ} differ"


def fast() -> str:
    """Three presets after place and route by PyPI's tools."""
    records = [record for key, record in stored("presets").items() if "yowasp" in key]
    timing, speeds = {record["name"]: record["timing"] for record in records}, []
    for name in ("learned_fast", "fast", "small"):
        times, core = timing[name], microarchitecture(load(ROOT / "examples" / f"{name}.toml").design)
        idle, most = times["frame_latency_us"], core.queued(0)[1] * times["interval_us"] / times["interval_cycles"]
        speeds.append(f"`{name}` {idle:,.1f} µs, at most {most:,.1f} µs at {times['frames_per_second']:,.0f} frames/s")
    text = "10×10 taxels, core alone, placed and routed, from the last taxel to the last word of a frame that is alone"
    return f"{text}: {'; '.join(speeds)} (published FPGA: {PUBLISHED_MS[0]} ms)"


def table() -> str:
    """Rows of the README."""
    answers = {"exact?": exact(), "verified?": verified(), "fast?": fast()}
    head = ["| is it | measured ([all tables](docs/measured.md)) |", "|---|---|"]
    return "\n".join([*head, *(f"| {question} | {answer} |" for question, answer in answers.items())])


if __name__ == "__main__":
    insert("headline", table(), "README.md")
