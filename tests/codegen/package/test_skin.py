"""Packages of skins: drivers take records apart and set how contacts are told apart; the datasheet states records."""

import json
import re
import struct
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.codegen.cocotb_run import outcome
from tests.codegen.package.c_driver import CCore, compiled
from tests.codegen.package.made import PART, write
from tests.codegen.package.test_datasheet import table
from tests.codegen.package.test_drivers import Answers, answers, c_program, imported, written
from tests.hdl.skin.skins import frames_of, skin_of, small_window
from tests.marks import long
from tests.sim.test_skin import TINY
from tfra.codegen.config.read import load
from tfra.codegen.generate import generate
from tfra.codegen.package.accuracy import accuracy
from tfra.codegen.package.contents import Contents
from tfra.codegen.package.datasheet import datasheet
from tfra.codegen.registers.source import registers_of
from tfra.codegen.sidecar.build import HEADER, sidecar
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.wrapper import module_name, ports_of, wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.framer import HEADER_WORDS, RECORDS_FORMAT
from tfra.hdl.ip.wrapper import skin_interval, skin_latencies
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.arrays import Ints
from tfra.model.fixed.words import decode
from tfra.model.skin.finding import MARK_SHIFT, MOST, Mark
from tfra.model.skin.records import decode_records, header_bits, record_layout, results
from tfra.model.skin.skin import Skin
from tfra.sim.tools import choose

SKIN = skin_of(9, 12, replace(small_window(3, 4), name="patch"), most=5)
BARE = skin_of(6, 9, replace(TINY, taxel_forces=False), most=3)
NAMES = list(HEADER)
FORMAT = RECORDS_FORMAT << 24


def codes_of(skin: Skin, count: int = 12) -> Ints:
    """Frames of which no taxel saturates."""
    return np.clip(frames_of(skin, 0, count), -1500, 1500)


def beats(skin: Skin, records: Ints, header: tuple[int, int] = (0, FORMAT), *, forces: bool = True) -> list[int]:
    """An output frame of the ``records (k, words)``, as the specification says."""
    kept = [
        place
        for field in record_layout(skin)
        if forces or field.name != "window.forces"
        for place in range(field.start, field.start + field.count)
    ]
    return [*header, *(records[:, kept].ravel() % (1 << 32)).tolist()]


def binary(frame: list[int]) -> bytes:
    return struct.pack(f"<{len(frame)}I", *frame)


@pytest.fixture(scope="module", params=[SKIN, *long(BARE)], ids=lambda skin: skin.name)
def package(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Skin, Path]:
    return request.param, written(tmp_path_factory.mktemp("package"), request.param)


@pytest.fixture(scope="module")
def program(package: tuple[Skin, Path]) -> Path:
    skin, folder = package
    return c_program(folder, skin, "contacts")


def test_places_of_the_record_are_those_of_the_model() -> None:
    assert list(header_bits(SKIN)) == NAMES


def test_records(package: tuple[Skin, Path], program: Path) -> None:
    """Contacts of C and of Python are those of the model's records, with forces and without."""
    skin, folder = package
    host, facts, each = imported(folder), sidecar(skin), results(skin, codes_of(skin))
    taken = [(records, forces) for records in each for forces in (True, False)]
    sent = [beats(skin, r, (0xABCD0000 | n, FORMAT | 0x3A4), forces=f) for n, (r, f) in enumerate(taken)]
    lines = answers(program, sent)
    assert {len(records) for records in each} >= {1, skin.choices.most}
    for number, ((records, forces), frame, line) in enumerate(zip(taken, sent, lines, strict=True)):
        known, header = decode_records(skin, records), dict(zip(NAMES, records[-1], strict=False))
        count = len(known.frame)
        parsed = host.parse_contacts(facts, binary(frame))
        assert (parsed.sequence, parsed.user, parsed.dropped) == (number, 0xABCD, header["dropped"])
        assert parsed.faults == {"saturation", "sequence_gap", "simulated", "out_of_range", "stuck"}
        assert [int(word) for word in line[:7]] == [0, number, 0xABCD, 0x3A4, header["frame"], header["dropped"], count]
        width = (len(line) - 7) // max(count, 1)
        for k, contact in enumerate(parsed.contacts):
            row = dict(zip(NAMES, records[k].tolist(), strict=False))
            assert dict(contact.words) == row
            assert [contact.x, contact.y, contact.taxels] == [known.x[k], known.y[k], known.taxels[k]]
            assert contact.marks == {mark.name for mark in Mark if row["marks"] & mark >> MARK_SHIFT}
            assert list(contact.window.resultant) == known.windows.resultant[k].tolist()
            assert [contact.window.mu, contact.window.phi_deg] == [known.windows.mu[k], known.windows.phi_deg[k]]
            assert (contact.window.forces is not None) == (forces and "window.forces" in _names(skin))
            mine = line[7 + k * width : 7 + (k + 1) * width]
            window = decode(skin.window, records[k : k + 1, len(NAMES) :])
            (exponent,) = contact.window.words["exponent"]
            integers = [*(row[name] for name in ("row", "column", "taxels", "marks")), row["frame"], 0xABCD, exponent]
            assert [int(word) for word in mine[:8]] == [*integers, contact.window.words["status"][0]]
            plain = [contact.x, contact.y, contact.window.phi_deg, contact.window.mu, *contact.window.resultant]
            assert [float.fromhex(word) for word in mine[8:15]] == plain
            planes = window.forces.ravel().tolist() if contact.window.forces else []
            assert [float.fromhex(word) for word in mine[15:]] == planes
            assert [force for plane in contact.window.forces or () for force in plane] == planes


def _names(skin: Skin) -> list[str]:
    return [field.name for field in record_layout(skin)]


def test_frames_in_a_stream(package: tuple[Skin, Path]) -> None:
    """Each is read up to its last record."""
    skin, folder = package
    host, facts = imported(folder), sidecar(skin)
    for forces in (True, False):
        sent = [binary(beats(skin, records, forces=forces)) for records in results(skin, codes_of(skin))]
        (folder / "frames.bin").write_bytes(b"".join(sent))
        with (folder / "frames.bin").open("rb") as source:
            assert [host.read_contacts(facts, source, forces) for _ in sent] == sent
            assert host.read_contacts(facts, source, forces) == b""


def test_bad_frames(package: tuple[Skin, Path], program: Path) -> None:
    skin, folder = package
    host, facts = imported(folder), sidecar(skin)
    records = next(each for each in results(skin, codes_of(skin)) if len(each) > 2)
    whole = beats(skin, records)
    size = (len(whole) - HEADER_WORDS) // len(records)

    def other(place: int, word: int) -> list[int]:
        return [*whole[:place], word, *whole[place + 1 :]]

    second = HEADER_WORDS + size
    bad = [
        *(([*whole[:count], 0xFFFFFFFF], 13, "soft reset") for count in (1, 2, 20, len(whole) - 1)),
        *((frame, 11, "bytes") for frame in ([], whole[:1], whole[:2], whole[:-1], [*whole, 0], whole[:-size])),
        *((other(second + NAMES.index(name), 9), 11, "bytes") for name in ("frame", "contact", "last")),
        ([*whole, *whole[-size:]], 11, "bytes"),
        (other(1, 1 << 24), 12, "format 1"),
        (other(second + len(NAMES) + 1, 1 << 20), 12, "window.exponent has more than"),
    ]
    lines = answers(program, [frame for frame, *_ in bad])
    assert [int(line[0]) for line in lines] == [code for *_, code, _ in bad]
    for frame, _, text in bad:
        with pytest.raises(host.DeviceError, match=text):
            host.parse_contacts(facts, binary(frame))


def test_settings(package: tuple[Skin, Path]) -> None:
    """Literal words, and refusals that write nothing, the same in both languages."""
    skin, folder = package
    host, library = imported(folder), compiled(folder, skin.name)
    registers = registers_of(skin)
    address = registers["CONTACTS"].address
    for make in (lambda bus: host.Core(bus, sidecar(skin)), lambda bus: CCore(library, host, bus, sidecar(skin), 5)):
        core = make(bus := Answers({}, registers=registers))
        assert vars(core.get_contacts()) == {"most": skin.choices.most, "threshold": 10, "gap": 2}
        for most, threshold, gap in ((0, 1, 0), (MOST + 1, 1, 0), (1, 0, 0), (1, 257, 0), (1, 1, 5)):
            with pytest.raises(ValueError, match=r"\w"):
                core.set_contacts(host.ContactSettings(most, threshold, gap))
        assert bus.written == []
        core.set_contacts(host.ContactSettings(MOST, 256, 4))
        assert bus.written == [(address, 64 | 4 << 7 | 256 << 10)]
        assert vars(core.get_contacts()) == {"most": 64, "threshold": 256, "gap": 4}


@pytest.mark.long
def test_settings_of_a_simulated_core(tmp_path: Path) -> None:
    """They count from the next frame on."""
    choose("icarus")
    settings = [(4, 10, 2), (1, 10, 2), (4, 200, 0), (3, 1, 4), (64, 10, 1)]
    skin = skin_of(6, 9, TINY, most=4)
    codes, expected, windows = codes_of(skin, 5), [], 0
    for number, (most, threshold, gap) in enumerate(settings):
        chosen = replace(skin.choices, most=most, threshold=threshold / 256, gap=gap)
        (records,) = results(replace(skin, choices=chosen), codes[number : number + 1])
        records[:, 0] = number
        records[:, len(NAMES)] += windows
        windows += len(records)
        expected.append(records.tolist())
    assert len({len(records) for records in expected}) > 2
    world = {
        "name": skin.name,
        "driver": "python",
        "sidecar": sidecar(skin),
        "frames": codes.reshape(len(codes), -1).tolist(),
        "taxels_per_beat": skin.window.bus.taxels_per_beat,
        "coefficients": microarchitecture(skin.window).loaded.ravel().tolist(),
        "results": [settings, expected],
    }
    verilog = {"axi.v": wrapper_verilog(skin), "core.v": to_verilog(skin)}
    write(written(tmp_path, skin), {**verilog, "world.json": json.dumps(world)})
    assert outcome("tests.codegen.package.bridge", "icarus", tmp_path, module_name(skin), "axi.v", "core.v") == ""


@pytest.fixture(scope="module")
def sheet() -> str:
    return datasheet(Contents(SKIN, sidecar(SKIN) | {"images": []}, {}, PART))["datasheet.html"]


def test_the_datasheet_states_a_record(sheet: str) -> None:
    """Every beat of it, its marks, and the first record of the testbench's frames."""
    rows, layout = table(sheet, "Output frame"), record_layout(SKIN)
    spans = [[int(beat) for beat in row[0].split(" … ")] for row in rows]
    covered = sorted({beat for span in spans for beat in range(span[0], span[-1] + 1)})
    assert covered == list(range(HEADER_WORDS + layout[-1].start + layout[-1].count))
    assert [row[2] for row in rows[-len(layout) :]] == [field.name for field in layout]
    assert [row[5] for row in rows if row[2] == "format"] == ["2: this format; all other bits of the beat are 0"]
    assert [row[1] for row in table(sheet, "Marks")] == [mark.name for mark in Mark]
    assert {row[1] for row in table(sheet, "Example")} == {field.name for field in layout}
    pins = [pin.name for pin in ports_of(SKIN)]
    assert [row[0] for row in table(sheet, "Ports of the wrapper")] == pins
    assert "$" not in re.sub(r"<(svg|style|script).*?</\1>", "", sheet, flags=re.S)


def test_the_datasheet_states_bounds_of_cycles(sheet: str) -> None:
    timing = SkinTiming.of(SKIN)
    expected = [*skin_latencies(timing), skin_interval(timing), timing.latency, timing.frame_latency, timing.interval]
    assert [int(row[1].replace(",", "")) for row in table(sheet, "Cycles")] == expected
    assert f"with {SKIN.choices.most} contacts, each with a region of {timing.taxels}" in sheet


def test_accuracy_is_of_the_contacts_that_were_found(sheet: str) -> None:
    count, found = accuracy(SKIN)
    by_name = {(row[0], row[1]): row[2:] for row in found.rows}
    missed = int(by_name["the simulated contact", "contacts missed"][0])
    assert 10 < count <= 60 - missed
    assert float(by_name["double precision, same codes", "F / % of |F|"][0]) < 0.1
    assert 1 < float(by_name["the simulated contact", "F / % of |F|"][0]) < 50
    assert table(sheet, "Accuracy") == [list(row) for row in found.rows]


@pytest.mark.long
def test_a_package(tmp_path: Path) -> None:
    """All its texts, which its own configuration makes again; none for boards, whose line has frames of one length."""
    folder = tmp_path / "package"
    generate(SKIN, folder, (), PART)
    assert not (folder / "boards").exists()
    readme = (folder / "README.md").read_text()
    assert "boards/" not in readme
    for name in re.findall(r"^\| `([^`]+)`", readme, re.M):
        assert (folder / name).is_file()
    assert "constant AT_CONTACTS : natural := 196;" in (folder / "patch_axi.vhd").read_text()
    assert "CONTACTS" in (folder / "patch_axi.xml").read_text()
    again = load(folder / "patch.toml").array
    assert isinstance(again, Skin)
    assert sidecar(again) == json.loads((folder / "patch.json").read_text())


def test_the_host_is_of_this_package(package: tuple[Skin, Path]) -> None:
    host: ModuleType = imported(package[1])
    assert host.registers.CONSTANTS["record"] == {name: place for place, name in enumerate(NAMES)}
