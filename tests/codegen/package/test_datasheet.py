"""The datasheet: every fact of the design is on it, and it loads nothing."""

import json
import re
import zlib
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tests.codegen.package.made import PARALLEL, PART, SERIAL_CORE
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design as learned
from tfra.codegen.package.accuracy import CONTACTS, SEED, accuracy
from tfra.codegen.package.contents import Contents
from tfra.codegen.package.datasheet import datasheet
from tfra.codegen.registers.source import registers_of
from tfra.codegen.sidecar.build import core_ports, sidecar
from tfra.codegen.verilog import testbench
from tfra.codegen.verilog.emit import run_yosys, to_verilog
from tfra.codegen.verilog.files import fingerprint
from tfra.codegen.verilog.wrapper import ports_of, wrapper_verilog
from tfra.families import find
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import cut_through, latencies
from tfra.model.cover.scenes import contact_codes, known_contacts
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.metrics import turn_deg
from tfra.recordings.facts import MEANINGS

DESIGNS = {"parallel": PARALLEL, "serial": SERIAL_CORE, "learned": learned(2, 3, taxel_forces=False)}

ANSWER = r"word comes ([\d.,]+) µs after .*? at ([\d,]+) frames a second, back to back, at most ([\d.,]+) µs"
"""Latency of a frame that is alone, the rate, and the latency at that rate."""


@pytest.fixture(scope="module", params=["serial", *long("parallel", "learned")])
def sheet(request: pytest.FixtureRequest) -> tuple[Design, str]:
    design = DESIGNS[request.param]
    return design, datasheet(Contents(design, sidecar(design) | {"images": []}, {}, PART))["datasheet.html"]


def table(page: str, label: str) -> list[list[str]]:
    """The rows of a table, cell by cell."""
    (body,) = re.findall(rf'aria-label="{label}"><table>.*?<tbody>(.*?)</tbody>', page, re.S)
    rows = (re.findall(r"<td[^>]*>(.*?)</td>", row, re.S) for row in re.findall(r"<tr.*?</tr>", body, re.S))
    return [[unescape(cell) for cell in row] for row in rows]


def test_every_beat_has_its_bits(sheet: tuple[Design, str]) -> None:
    """Beats follow each other without a gap, and their number is that of the text."""
    design, page = sheet
    rows = table(page, "Output frame")
    spans = [[int(beat) for beat in row[0].split(" … ")] for row in rows]
    covered = [range(span[0], span[-1] + 1) for span in spans]
    assert sorted({beat for span in covered for beat in span}) == list(range(2 + design.frame_words))
    words = rows[next(n for n, row in enumerate(rows) if row[0] == "2") :]
    assert [row[2] for row in words] == [field.name for field in design.layout]
    for row, field in zip(words, design.layout, strict=True):
        assert row[1].startswith(f"{field.bits - 1}:0, {'sign' if field.signed else 'zeros'}")
        assert float(row[4].split()[0]) == pytest.approx(field.lsb, rel=1e-5)
    assert "its bit 2 is about taxels alone" in page
    header = "15:0 sequence 31:16 user 2 saturation 5 sequence_gap 7 simulated 8 out_of_range 9 stuck 31:24 format"
    assert [cell for row in rows if row[0] in "01" for cell in row[1:3]] == header.split()
    assert f"A frame has {2 + design.frame_words} beats" in page


@pytest.mark.long
def test_the_clock_is_that_of_just_this_verilog(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Comments do not count; what was measured of another Verilog or another part is not stated."""
    clock = {"median_mhz": 123.4, "asked_mhz": 120.0, "seeds": [{"seed": 7, "mhz": 123.4}]}
    used = {"LUT": {"used": 12300}, "DSP": {"used": 10}}
    row = {"name": "lanes_axi", "target": PART.target.name, "netlist": fingerprint(["core\n", "wrapper\n"])}
    row |= {"clock": clock, "resources": used, "tools": {"nextpnr": "1"}}
    file = tmp_path / "measured.json"
    file.write_text(json.dumps([row]))
    monkeypatch.setattr("tfra.codegen.package.contents._MEASURED", file)
    facts, texts = sidecar(PARALLEL) | {"images": []}, {"lanes.v": "// today\ncore\n", "lanes_axi.v": "wrapper\n"}
    found = datasheet(Contents(PARALLEL, facts, texts, PART))["datasheet.html"]
    assert "At 123.4 MHz" in found
    assert "123.4 MHz (seed 7). <code>python3 netlist/place.py SEED 120</code>" in found
    assert table(found, "Resources")[0] == ["LUT", "24,288", "9,000", "37%", "12,300", "51%"]
    for other, part in (({**texts, "lanes.v": "gore\n"}, PART), (texts, replace(PART, target=find("ecp5-45")))):
        found = datasheet(Contents(PARALLEL, facts, other, part))["datasheet.html"]
        assert "This core was not placed: 98 MHz" in found


def test_the_example_is_the_first_frame_of_the_testbench(sheet: tuple[Design, str]) -> None:
    design, page = sheet
    words = design.model(contact_codes(design, testbench.CONTACTS, testbench.SEED)[:1]).words
    result, rows = decode(design, words), table(page, "Example")
    for beat, _, sent, number, _ in rows:
        word = int(words[0, int(beat) - 2])
        assert (int(sent, 16), int(number.replace(",", ""))) == (word % (1 << 32), word)
    shown = {name: [float(row[4].split()[0]) for row in rows if row[1] == name] for name in ("resultant", "mu", "phi")}
    assert shown["resultant"] == pytest.approx(result.resultant[0].tolist(), rel=1e-5)
    assert shown["mu"] + shown["phi"] == pytest.approx([result.mu[0], result.phi_deg[0]], rel=1e-5)
    assert {row[1] for row in rows} == {field.name for field in design.layout}


@pytest.mark.long
def test_other_families_count_the_verilog(tmp_path: Path) -> None:
    """By the commands on the page; a core of a family's cells has none."""
    contents = Contents(PARALLEL, sidecar(PARALLEL) | {"images": []}, {}, PART)
    lines = re.findall(r'^(?:<pre>)?yosys -p "(.*)"', unescape(datasheet(contents)["datasheet.html"]), re.M)
    (tmp_path / "lanes.v").write_text(to_verilog(PARALLEL))
    (tmp_path / "lanes_axi.v").write_text(wrapper_verilog(PARALLEL))
    (line,) = (line for line in lines if "gowin" in line)
    run_yosys(line.replace("; stat", "; tee -o stat.txt stat"), tmp_path)
    counted = re.findall(r"(\d+) .*MULT18X18$", (tmp_path / "stat.txt").read_text(), re.M)
    assert int(counted[-1]) >= PARALLEL.architecture.mac_lanes
    cells = replace(contents, array=replace(PARALLEL, target="ecp5"))
    assert "synth_gowin" not in datasheet(cells)["datasheet.html"]


def test_every_status_bit_register_and_port_is_there(sheet: tuple[Design, str]) -> None:
    design, page = sheet
    status = {int(row[0]): row[2] for row in table(page, "Status")}
    assert status == {flag.bit_length() - 1: MEANINGS[flag] for flag in design.status_bits}
    registers, rows = registers_of(design).registers, table(page, "Registers")
    assert [(row[0], row[1]) for row in rows if row[0]] == [(f"0x{r.address:02X}", r.name) for r in registers]
    assert [row[3] for row in rows] == [field.name for register in registers for field in register.fields]
    pins = [pin.name for pin in ports_of(design)]
    assert [row[0] for row in table(page, "Ports of the wrapper")] == pins
    assert [row[0] for row in table(page, "Ports of the core")] == [port.name for port in core_ports(design)]
    assert re.findall(r"\.(\w+)\((\w+)\)", page) == [(pin, pin) for pin in pins]


def test_cycles_and_times(sheet: tuple[Design, str]) -> None:
    design, page = sheet
    core, rows = microarchitecture(design), table(page, "Cycles")
    idle, most = latencies(core)[:2], latencies(core)[2:]
    expected = [*idle, *cut_through(core), *most, core.initiation_interval, core.latency, core.frame_latency]
    assert [int(row[1].replace(",", "")) for row in rows] == expected
    for row, cycles in zip(rows, expected, strict=True):
        assert float(row[2].replace(",", "")) == pytest.approx(cycles / 98.0, abs=0.006)
    first, rate, most = (float(each.replace(",", "")) for each in re.findall(ANSWER, page, re.S)[0])
    assert [first, most] == pytest.approx([latencies(core)[n] / 98.0 for n in (0, 2)], abs=0.06)
    assert rate == pytest.approx(98e6 / core.initiation_interval, abs=1)
    assert f"{expected[1]:,} cycles or more after the one before" in page
    assert f"end {min(core.intervals):,} to {max(core.intervals):,} cycles apart" in page


def test_loads_are_told_with_their_checksum(sheet: tuple[Design, str]) -> None:
    design, page = sheet
    words = microarchitecture(design).loaded
    if words is None:
        assert "LOAD_WORDS is 0" in page
        return
    crc = zlib.crc32(np.asarray(words, dtype="<i4").tobytes())
    assert page.count(f"0x{crc:08X}") == 2
    assert f"{len(words):,} words" in page


def test_the_coding_of_words_is_told(sheet: tuple[Design, str]) -> None:
    """Of offset binary, too, which is not that after a reset."""
    (field,) = (field for field in registers_of(sheet[0])["FRONT_END"].fields if field.name == "is_unsigned")
    assert field.reset == 0
    assert "of offset binary needs is_unsigned = 1" in sheet[1].replace("\n", " ")


def test_accuracy_is_that_of_the_model() -> None:
    """Percentiles over the contacts that have a direction."""
    count, found = accuracy(PARALLEL)
    drawn = known_contacts(PARALLEL, CONTACTS, SEED)
    result = decode(PARALLEL, PARALLEL.model(drawn.codes).words)
    clear = PARALLEL.float_model(drawn.codes * PARALLEL.adc.lsb).status == 0
    assert count == clear.sum()
    own = {"μ": np.abs(result.mu - drawn.mu)[clear], "φ / °": turn_deg(result.phi_deg, drawn.phi_deg)[clear]}
    for name, *stated in (row[1:] for row in found.rows if row[0] == "the simulated contact" and row[1] in own):
        assert [float(cell) for cell in stated] == pytest.approx(np.percentile(own.pop(name), (50, 95)), rel=5e-3)
    assert not own


@pytest.mark.long
def test_it_loads_nothing_and_everyone_can_read_it(sheet: tuple[Design, str], tmp_path: Path) -> None:
    (tmp_path / "datasheet.html").write_text(sheet[1])
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "datasheet.html")
        assert tab.requests == []
        assert tab.messages == []
        assert faults_at_all_widths(tab) == []
