"""Verification finds what is wrong, names it, and passes what is right."""

import json
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tfra.hdl.parallel.matvec.images import lane_images
from tfra.hdl.parallel.tfra.core import TfraParallel
from tfra.model.choices import Adc, Architecture, Search
from tfra.model.converter import quantise
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra, Stage
from tfra.model.fixed.words import decode
from tfra.model.metrics import ERRORS
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status
from tfra.sim.pattern_run import first_difference
from tfra.sim.render import page, render
from tfra.sim.report import Account, Report
from tfra.sim.run import Netlist, Run, generated, simulate
from tfra.sim.stimuli import mixture
from tfra.sim.verify import verify

DESIGN = TfraDesign(
    SensorArray(3, 2, 4e-3, 4e-3, 3e-3),
    name="tiny",
    search=Search(8),
    architecture=Architecture(4),
)


@pytest.fixture(autouse=True)
def cache(builds: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TFRA_CACHE", str(builds))
    return builds


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few frames of each kind."""
    monkeypatch.setattr("tfra.sim.stimuli.CONTACTS", 6)
    monkeypatch.setattr("tfra.sim.stimuli.directed_codes", lambda design: directed_codes(design)[1::3])


def tampered(cache: Path, old: str, new: str) -> Netlist:
    """The generated core with its Verilog changed."""
    good = generated(DESIGN, cache)
    assert old in good.verilog
    return replace(good, verilog=good.verilog.replace(old, new))


@pytest.mark.usefixtures("few")
@pytest.mark.long
def test_memory_files_pass_and_a_wrong_word_in_one_fails(cache: Path) -> None:
    design = replace(DESIGN, images="readmemh")
    assert verify(design, simulator="verilator", random=20).passed
    good = generated(design, cache)
    file = good.sidecar["images"][-1]["file"]
    words = good.images[file].split()
    words[0] = f"{int(words[0], 16) ^ 0x100:x}"
    wrong = replace(good, images={**good.images, file: "\n".join(words)})
    assert not verify(design, simulator="verilator", random=20, core=wrong).passed


@pytest.mark.usefixtures("few")
@pytest.mark.long
def test_loaded_coefficients_pass_and_a_wrong_one_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    design = replace(DESIGN, images="load", target="ecp5")
    assert verify(design, simulator="icarus", random=0).passed
    wrong = lane_images(design).ravel()
    wrong[0] ^= 0x100
    monkeypatch.setattr(TfraParallel, "loaded", wrong)
    assert not verify(design, simulator="icarus", random=0).passed


def check_accounts(report: Report) -> dict[tuple[str, str], Account]:
    """Raise ``AssertionError`` unless every frame of every kind is compared or left out, in each comparison."""
    found = {(account.kind, account.against): account for account in report.accounts}
    assert list(found) == [(kind, against) for kind in report.kinds for against in ("model", "float", "contact")]
    for (kind, _), account in found.items():
        assert account.compared + sum(account.left_out.values()) == account.frames == report.kinds[kind]
        assert 0 not in account.left_out.values()
    for against in ("model", "float", "contact"):
        assert sum(a.frames for a in report.accounts if a.against == against) == report.frames
    for kind, errors in report.against_float.items():
        assert found[kind, "float"].compared == errors.frames
    truth = sum(a.compared for a in report.accounts if a.against == "contact")
    assert truth == (report.against_contact.frames if report.against_contact else 0)
    return found


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_a_good_core_passes() -> None:
    """Without stalls, the core gets every third frame; of many it shows the interval, too."""
    random = 94
    progress: list[tuple[int, int]] = []
    report = verify(DESIGN, simulator="icarus", random=random, progress=lambda *now: progress.append(now))
    assert report.passed
    assert report.kinds == {"contact": 6, "random": random, "directed": len(directed_codes(DESIGN)[1::3])}
    assert report.frames == sum(done for done, _ in progress) == sum(report.kinds.values())
    assert {every for _, every in progress} == {report.frames}
    assert report.compared == report.words == report.frames * (DESIGN.layout[-1].start + 1)
    assert (report.mismatches, report.first, report.violations) == (0, None, ())
    assert report.timing.latency == report.timing.design_latency is not None
    assert report.timing.interval == (report.timing.design_interval)
    assert set(report.against_float) == {"contact", "random", "directed"}
    back = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert (back["passed"], back["frames"]) == (True, report.frames)
    accounts = check_accounts(report)
    assert all(accounts[kind, "model"].left_out == {} for kind in report.kinds)
    assert accounts["random", "contact"].left_out == {"no_true_values": random}
    result = decode(DESIGN, FixedTfra(DESIGN)(directed_codes(DESIGN)[1::3]).words)
    left = accounts["directed", "float"].left_out
    assert left["NO_CONTACT"] == (result.status & Status.NO_CONTACT != 0).sum()
    assert left["COMPRESSION_ONLY"] == (result.status & Status.COMPRESSION_ONLY != 0).sum()
    with pytest.raises(AssertionError):
        check_accounts(replace(report, accounts=(replace(report.accounts[0], compared=0), *report.accounts[1:])))
    assert not replace(report, compared=report.compared - 1).passed
    assert not replace(report, timing=replace(report.timing, latency=report.timing.latency + 1)).passed
    console = Console(record=True, width=80)
    render(report, console)
    shown = console.export_text()
    assert "every bit equals the model" in shown
    assert f"│ random   │     {random:2} │ true values      │        0 │ {random} no true values" in shown
    assert max(map(len, shown.splitlines())) <= 80
    assert "…" not in shown
    assert all(f"│ {name} " in shown for name in ERRORS.values())
    text = page(report)
    assert '<p class="answer">Every bit equals the model: ' in text
    assert "failed" not in text.partition("</style>")[2]
    wide = Console(record=True, width=400)
    render(report, wide)
    cells = [cell.strip() for line in wide.export_text().splitlines() for cell in line.split("│")[1:-1]]
    assert len(cells) > 80
    assert all(escape(cell) in text for cell in cells)  # those of the terminal


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_the_page_of_a_good_core(tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text(page(verify(DESIGN, simulator="icarus", random=20)))
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "page.html", 390)
        assert tab.evaluate("document.documentElement.scrollWidth") == 390
        assert faults_at_all_widths(tab) == []
        assert (tab.messages, tab.requests) == ([], [])


@pytest.mark.long
def test_given_frames_and_references() -> None:
    """True values that are off by a known amount: every error is in the unit of its key."""
    frames = np.random.default_rng(3).normal(0.0, 2e4, (6, 3, 2))
    result = decode(DESIGN, FixedTfra(DESIGN)(quantise(DESIGN, frames)).words)
    good = result.status == 0
    assert good.sum() > 2
    known = {"resultant_ref": np.add(result.resultant, (0.0, 0.0, 1.0)), "mu_ref": result.mu + 0.25}
    known["phi_ref_deg"] = result.phi_deg - 36.0
    report = verify(DESIGN, frames, "icarus", random=3, references=known)
    assert report.passed
    assert report.kinds == {"given": 6, "random": 3}
    assert report.timing.interval is None  # too few frames to tell
    errors = report.as_dict()["against_contact"]
    assert errors["frames"] == good.sum()
    expected = {"phi_deg": 36, "mu_abs": 0.25, "force_n": 1, "paper_phi_percent_of_turn": 10}
    for part in (errors["median"], errors["largest"]):
        assert {key: part[key] for key in expected} == pytest.approx(expected)
    modulus = np.linalg.norm(known["resultant_ref"][good], axis=1)
    assert errors["largest"]["force_percent_of_resultant"] == pytest.approx(100 / modulus.min())
    with pytest.raises(ValueError, match=r"mu_ref: shape \(6,\) is needed, got \(3,\)"):
        verify(DESIGN, frames, "icarus", references=known | {"mu_ref": np.zeros(3)})


@pytest.mark.long
def test_every_probe_shows_the_models_stage(cache: Path) -> None:
    """Of frames that are alone in the core: those that overlap would interleave at some probes."""
    for codes in (contact_codes(DESIGN, 1, 1), directed_codes(DESIGN)[:1], wild_codes(DESIGN, 1, 1)):
        model = FixedTfra(DESIGN)(codes)
        run = simulate(DESIGN, codes, "icarus", build_dir=cache, probes=True)
        assert list(run.probes) == [stage for stage in Stage if stage != Stage.SCALING]
        for stage, found in run.probes.items():
            np.testing.assert_array_equal(found, model.stages[Stage(stage)].reshape(1, -1), stage)


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_wrong_coefficients_are_traced_to_their_stage(cache: Path) -> None:
    first = f"18'h{lane_images(DESIGN)[0, 0] & 0x3FFFF:05x}"
    wrong = tampered(cache, first, "18'h00000")
    report = verify(DESIGN, simulator="icarus", random=0, core=wrong)
    assert not report.passed
    assert report.mismatches > 0
    assert report.first is not None
    assert (report.first.stage, report.first.transfer) == ("matvec", 0)
    console = Console(record=True, width=200)
    render(report, console)
    assert "first mismatch: frame" in console.export_text()
    text = page(report)
    assert '<p class="answer failed">Failed: ' in text
    assert '<p class="answer failed">first mismatch: frame' in text


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_a_flipped_result_bit_is_found_behind_all_probes(cache: Path) -> None:
    old = "assign result_data = "
    wrong = tampered(cache, old, f"{old}1 ^ ")
    report = verify(DESIGN, simulator="icarus", random=0, core=wrong)
    assert not report.passed
    assert report.mismatches == report.compared
    first = report.first
    assert first is not None
    assert (first.frame, first.field, first.word, first.taxel, first.stage) == (0, "frame", 0, None, "scaling")
    assert first.expected ^ first.observed == 1


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_waves_are_of_the_frame_that_differs(cache: Path, tmp_path: Path) -> None:
    """A core that is wrong from its fifth frame on: alone that frame is right, so those before it are played, too."""
    old = "assign result_data = "
    ends = "result_valid & result_ready & result_last"
    counter = f"reg [15:0] taken = 0;\n  always @(posedge clk) if ({ends}) taken <= taken + 1;"
    wrong = tampered(cache, old, f"{counter}\n  {old}(taken >= 4) ^ ")
    file = tmp_path / "waves.vcd"
    report = verify(DESIGN, simulator="icarus", random=0, core=wrong, waves=file)
    assert report.first is not None
    assert report.recorded == report.first.frame == 12  # the fifth of every third
    assert verify(DESIGN, simulator="icarus", random=0, waves=tmp_path / "good.vcd").recorded == 0
    assert (tmp_path / "good.vcd").stat().st_size < file.stat().st_size


@pytest.mark.long
@pytest.mark.usefixtures("few")
def test_a_broken_stream_fails(cache: Path, tmp_path: Path) -> None:
    wrong = tampered(cache, "assign result_last = ", "assign result_last = 0 & ")
    report = verify(DESIGN, simulator="icarus", random=0, core=wrong, waves=tmp_path / "waves.vcd")
    assert (tmp_path / "waves.vcd").exists()
    assert not report.passed
    assert any("last is missing" in note for note in report.violations)
    accounts = check_accounts(report)
    for kind, count in report.kinds.items():
        assert accounts[kind, "float"].left_out == accounts[kind, "contact"].left_out == {"not_returned": count}
    json.dumps(report.as_dict(), allow_nan=False)


def test_first_difference_names_the_first_stage_in_order() -> None:
    codes = np.random.default_rng(3).integers(-8192, 8192, (3, 3, 2))
    model = FixedTfra(DESIGN)(codes)
    order = ("normaliser", "centroids", "combine", "sweep")

    def run(**changes: tuple[int, int]) -> Run:
        probes = {stage: model.stages[stage].reshape(3, -1).copy() for stage in order}
        for stage, place in changes.items():
            probes[stage][place] += 1
        nothing = np.empty(0, dtype=np.int64)
        return Run(model.words, nothing, nothing, "icarus", 0, 0, 0, probes)

    assert first_difference(run(), model, 1) == ("scaling", None)
    assert first_difference(run(sweep=(1, 0)), model, 1) == ("sweep", 0)
    assert first_difference(run(sweep=(1, 0), combine=(1, 9)), model, 1) == ("combine", 2)
    assert first_difference(run(combine=(2, 9)), model, 1) == ("scaling", None)
    short = run()
    short.probes["combine"] = short.probes["combine"][:1]
    assert first_difference(short, model, 1) == ("combine", None)


@pytest.mark.parametrize("bits", [6, 14, 20])
def test_stimuli_fit_the_converter_and_follow_the_seed(bits: int) -> None:
    design = replace(DESIGN, adc=Adc(bits), formats=replace(DESIGN.formats, operand=20))
    first, again, other = (mixture(design, seed, 30) for seed in (1, 1, 2))
    half = 1 << (bits - 1)
    assert first.codes.min() == -half
    assert first.codes.max() == half - 1
    np.testing.assert_array_equal(first.codes, again.codes)
    assert (first.codes != other.codes).any()
    known = first.kinds == "contact"
    np.testing.assert_array_equal(np.isfinite(first.mu), known)
    assert (first.resultant[known, 2] < 0).all()


def test_directed_frames_reach_the_special_cases() -> None:
    status = FixedTfra(DESIGN)(directed_codes(DESIGN)).words[:, -1]
    for flag in (Status.NO_CONTACT, Status.COMPRESSION_ONLY, Status.NO_DIRECTION, Status.INPUT_SATURATED):
        assert (status & flag != 0).any(), flag
