"""From SystemRDL to the map, and from a design to the values of the constant registers."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.model.fixed.learned.cases import learned_design
from tfra.codegen.registers.source import SOURCE, as_map, compiled, parameters, register_map, registers_of
from tfra.hdl.bus.map import Kind
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import latencies
from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding
from tfra.model.skin.records import record_words
from tfra.model.skin.skin import Skin
from tfra.runtime.errors import InputError

ROOT = Path(__file__).parents[3]
DESIGN = TfraDesign(SensorArray(3, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4))


def test_every_address_is_in_the_source_and_every_bit_is_described() -> None:
    registers = register_map({"SKIN": 1})
    stated = {name: int(place, 16) for name, place in re.findall(r"} (\w+) @ (0x\w+);", SOURCE.read_text())}
    assert {register.name: register.address for register in registers.registers} == stated
    assert len(set(stated.values())) == len(stated)
    assert registers.address_bits == 8
    assert all(each.text.endswith(".") for r in registers.registers for each in (r, *r.fields))


def test_constants_are_the_cheap_ones() -> None:
    """They are in the first sixteen words, all of them and nothing else."""
    for register in register_map({"SKIN": 1}).registers:
        assert (register.address < 0x40) == all(f.kind is Kind.CONSTANT for f in register.fields), register.name


def test_a_skin_alone_has_windows_and_contacts() -> None:
    assert {register.name for register in register_map({}).registers}.isdisjoint({"WINDOW", "CONTACTS"})
    skin = Skin(SensorArray(6, 9, 4e-3, 4e-3, 3e-3), DESIGN, Finding(most=5, threshold=0.5, gap=1))
    registers = registers_of(skin)
    found = {f"{r.name}.{f.name}": f.reset for r in registers.registers for f in r.fields}
    assert (found["SENSOR.rows"], found["SENSOR.columns"]) == (6, 9)
    assert (found["WINDOW.rows"], found["WINDOW.columns"]) == (3, 2)
    assert [found[f"CONTACTS.{name}"] for name in ("most", "threshold", "gap")] == [5, 128, 1]
    assert found["RESULT_WORDS.words"] == record_words(skin)


@pytest.mark.parametrize(
    ("fields", "key", "reason"),
    [
        ("field { sw = r; hw = w; swmod; } a[1];", "R.a", "no kind of field has sw = r, hw = w, swmod"),
        ("field { sw = rw; hw = rw; } a[1] = 0;", "R.a", "no kind of field has sw = rw, hw = rw, and nothing else"),
        ("field { sw = rw; hw = na; onwrite = woclr; hwset; } a[1] = 0;", "R.a", "no kind of field"),
        ("field { sw = rw; hw = na; onwrite = woclr; hwset; precedence = hw; } a[2] = 0;", "R.a", "one bit"),
        ("field { sw = r; hw = na; counter; hwclr; } a[2] = 0;", "R.a", "hwclr is another field"),
        ("field { sw = r } a[1];", "", "missing ';'"),
    ],
)  # fmt: skip
def test_a_field_that_is_not_offered_is_refused(tmp_path: Path, fields: str, key: str, reason: str) -> None:
    source = tmp_path / "wrong.rdl"
    source.write_text(f"addrmap wrong {{ reg {{ {fields} }} R @ 0x0; }};\n")
    with pytest.raises(InputError, match=re.escape(reason)) as error:
        as_map(compiled({}, source), source)
    assert str(error.value).startswith(f"{source}: {key}" if key else f"{source}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("body", ["regfile { reg { field {} a[1]; } R; } F;", "reg { field {} a[1]; } R[2];"])
def test_only_single_registers_are_offered(tmp_path: Path, body: str) -> None:
    source = tmp_path / "wrong.rdl"
    source.write_text(f"addrmap wrong {{ {body} }};\n")
    with pytest.raises(InputError, match="single registers of 32 bits are needed"):
        as_map(compiled({}, source), source)


def test_values_of_a_design() -> None:
    registers, core = register_map(parameters(DESIGN)), microarchitecture(DESIGN)
    values = {f"{r.name}.{f.name}": f.reset for r in registers.registers for f in r.fields if f.kind is Kind.CONSTANT}
    assert values.pop("CONFIG_HASH_LOW.bits") != values.pop("CONFIG_HASH_HIGH.bits")
    assert values == {
        **{"ID.text": int.from_bytes(b"TFRA", "big"), "INPUT.taxels_per_beat": 1, "INPUT.repair_places": 512},
        **{"VERSION.major": 0, "VERSION.minor": 1, "VERSION.patch": 0, "VERSION.map": 1},
        **{f"CAPABILITIES.{name}": 0 for name in ("estimator", "architecture", "loadable")},
        **{"CAPABILITIES.taxel_forces": 1, "SENSOR.rows": 3, "SENSOR.columns": 2},
        **{"WORD_LENGTHS.taxel_bits": DESIGN.adc.bits, "WORD_LENGTHS.result_bits": DESIGN.word_bits},
        **{"WORD_LENGTHS.coefficient_bits": DESIGN.coefficient_word, "RESULT_WORDS.words": DESIGN.frame_words},
        **{"LATENCY.cycles": latencies(core)[0], "INTERVAL.cycles": core.initiation_interval, "LOAD_WORDS.words": 0},
    }


def test_other_designs_have_other_values() -> None:
    serial = replace(DESIGN, architecture=Architecture(0, kind="serial", vector_words=0))
    learned = replace(learned_design(2, 2), taxel_forces=False)
    seen = parameters(serial)
    loaded = microarchitecture(serial).loaded
    assert loaded is not None
    assert (seen["ARCHITECTURE"], seen["LOADABLE"], seen["LOAD_LENGTH"]) == (1, 1, loaded.size)
    seen = parameters(learned)
    assert (seen["ESTIMATOR"], seen["TAXEL_FORCES"]) == (1, 0)
