"""The README's table of what was measured, from the results of the campaigns: ``python -m bench.headline``."""

from bench.parts.presets import PUBLISHED_MS, rows
from bench.publish import ROOT, insert, stored
from bench.scorecard.words.measure import wrong_words
from tfra.codegen.config.read import load
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import latencies


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
    configurations = next(line for line in stored("scorecard") if line["number"] == 1)["facts"]["configurations"]
    axi = stored("axi")["records"]
    words = sum(record["words"] for record in (*configurations, *axi))
    differ = sum(map(wrong_words, configurations)) + sum(len(record["differences"]) for record in axi)
    return f"{words:,} result words of Verilog, alone and behind AXI ([scorecard](docs/scorecard.md)): {differ} differ"


def fast() -> str:
    """Presets behind AXI, after place and route."""
    timing, speeds = {row["name"]: row["timing"] for row in rows()}, []
    for name in (name for name in ("learned_resultant", "learned_fast", "fast") if f"{name}_axi" in timing):
        times, core = timing[f"{name}_axi"], microarchitecture(load(ROOT / "examples" / f"{name}.toml").design)
        idle, most = times["frame_latency_us"], latencies(core)[3] * times["interval_us"] / times["interval_cycles"]
        speeds.append(f"`{name}` {idle:,.1f} µs, at most {most:,.1f} µs at {times['frames_per_second']:,.0f} frames/s")
    text = "10×10 taxels behind AXI, placed and routed, from the last taxel to the last word of a frame that is alone"
    return f"{text}: {'; '.join(speeds)} (published FPGA: {PUBLISHED_MS[0]} ms)"


def table() -> str:
    """Rows of the README."""
    answers = {"exact?": exact(), "verified?": verified(), "fast?": fast()}
    head = ["| is it | measured ([all tables](docs/measured.md)) |", "|---|---|"]
    return "\n".join([*head, *(f"| {question} | {answer} |" for question, answer in answers.items())])


if __name__ == "__main__":
    insert("headline", table(), "README.md")
