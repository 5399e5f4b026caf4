"""``tfra init``'s file: it is the design that was asked for, and has a comment for every key."""

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.codegen.config.examples import examples
from tfra.codegen.config.read import build_project
from tfra.codegen.config.schema import Document
from tfra.codegen.config.write import EXAMPLE, commented
from tfra.model.choices import FORMATS

SKIN = {"rows": 8, "columns": 12, "pitch_x_mm": 3.0, "pitch_y_mm": 2.5, "thickness_mm": 3.0}


def text_of(sensor: dict[str, Any], **sections: Any) -> str:
    project = build_project({"name": "skin", "sensor": sensor, **sections}, Path("skin.toml"))
    return commented(project.design, project.layer)


def read(text: str) -> Any:
    return build_project(tomllib.loads(text), Path("skin.toml"))


LENGTHS = st.decimals(0, 9, places=3).map(float).map(lambda x: x + 0.8)


@settings(max_examples=15, deadline=None)
@given(
    rows=st.integers(2, 12),
    columns=st.integers(2, 12),
    lengths=st.tuples(LENGTHS, LENGTHS, LENGTHS),
    bits=st.integers(6, 18),
    full_scale=st.floats(2e3, 9e6),
    kind=st.sampled_from(["parallel", "serial"]),
    family=st.sampled_from(["portable", "ecp5", "ice40"]),
)
def test_it_is_the_design_and_no_frame_is_over_full_scale(
    rows: int, columns: int, lengths: tuple[float, ...], bits: int, full_scale: float, kind: str, family: str
) -> None:
    keys = ("pitch_x_mm", "pitch_y_mm", "thickness_mm")
    content: dict[str, Any] = {
        "name": "skin",
        "sensor": {"rows": rows, "columns": columns}
        | {key: round(x, 3) for key, x in zip(keys, lengths, strict=True)},
        "adc": {"bits": bits, "full_scale_pa": full_scale},
        "architecture": {"kind": kind},
        "target": {"name": family},
    }
    expected = build_project(content, Path("skin.toml"))
    found = read(commented(expected.design, expected.layer))
    assert (found.design, found.layer) == (expected.design, expected.layer)
    frames = found.layer.frames(found.design.sensor, found.contacts)
    assert len(frames) == 24
    peak = np.abs(frames).max(axis=(1, 2))
    assert (peak < full_scale).all()
    assert (peak >= full_scale * 2.0 ** (1 - bits)).all()


def test_every_key_has_a_comment_and_is_there() -> None:
    """The example is the one home of these comments: it has each key of the schema, and so has the new file."""
    for text in (examples()[EXAMPLE], text_of(SKIN)):
        section, found = "", set()
        for line in text.splitlines():
            if head := re.match(r"(?:# )?\[+(\w+)\]+", line):
                section = head[1]
            elif key := re.match(r"(?:# )?(\w+) = .*? # \w*", line):
                found.add((section, key[1]))
        needed = set()
        for name, field in Document.model_fields.items():
            kind = field.annotation
            kind = getattr(kind, "__args__", (kind,))[0]
            keys = getattr(kind, "model_fields", None)
            needed |= {("", name)} if keys is None else {(name, key) for key in keys}
        assert needed - found == {("formats", "signals")}  # a table of its own, docs/numerics.md
        assert len(needed) > 40


def test_what_is_commented_out_is_the_default() -> None:
    """With all of it switched on, one at a time, the design and the places of contacts stay."""
    text = text_of(SKIN, adc={"bits": 12, "full_scale_pa": 150e3})
    plain = read(text)
    for key in ("contact_threshold_codes", "center_x_mm", "center_y_mm", "name", "coefficient_bits", "unit", "order"):
        changed = re.sub(rf"(?m)^# ({key} = )", r"\1", text)
        changed = changed.replace("# [input]", "[input]")
        assert changed != text
        found = read(changed)
        assert found.design.adc.threshold == plain.design.adc.threshold
        assert found.contacts == plain.contacts
        assert found.input == plain.input
        assert found.design.formats.coefficient == FORMATS["standard"].coefficient


def test_remarks_on_the_example_are_left_out() -> None:
    assert "72 kPa" in examples()[EXAMPLE]
    assert "72 kPa" not in text_of(SKIN)
    assert "hertz_40x20" not in text_of(SKIN)


@pytest.mark.parametrize("name", ["hertz_40x20", "skin_8x12"])
def test_examples_are_those_of_the_folder(name: str) -> None:
    assert examples()[name] == (Path(__file__).parents[3] / "examples" / f"{name}.toml").read_text()
    folder = Path(__file__).parents[3] / "examples"
    assert set(examples()) == {path.name.removesuffix(".toml") for path in folder.glob("*.[tc]*")}
