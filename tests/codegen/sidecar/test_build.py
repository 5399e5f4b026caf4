"""The sidecar: its schema, and that a program can read a core's words with nothing else."""

import contextlib
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from tfra.codegen.config.read import load
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.sidecar.schema import schema
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import latencies
from tfra.model.choices import Adc, Architecture, Search
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.words import decode
from tfra.model.sensor import SensorArray

ROOT = Path(__file__).parents[3]
DESIGN = TfraDesign(SensorArray(3, 4, 4e-3, 2e-3, 3e-3), name="small", architecture=Architecture(4, 1))


def test_the_published_schema_is_current() -> None:
    """``python -m tfra.codegen.sidecar.schema > docs/core.schema.json`` renews it."""
    assert (ROOT / "docs" / "core.schema.json").read_text() == schema()


@pytest.mark.parametrize("name", ["fast", "small", "learned_resultant"])
def test_sidecars_follow_the_schema(name: str) -> None:
    design = load(ROOT / "examples" / f"{name}.toml").design
    facts = json.loads(json.dumps(sidecar(design)))
    jsonschema.validate(facts, json.loads(schema()))
    core = microarchitecture(design)
    stated = [(facts[key]["first_word"], facts[key]["last_word"]) for key in ("latency_cycles", "axi_latency_cycles")]
    assert stated == [(core.latency, core.frame_latency), latencies(core)[:2]]
    assert [2 ** bit["bit"] for bit in facts["result"]["status_bits"]] == [int(bit) for bit in design.status_bits]
    assert ("load" in facts) == (core.loaded is not None)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(facts | {"latency_cycles": 3}, json.loads(schema()))


def test_every_length_names_its_unit() -> None:
    """Numbers with a fraction are lengths, stresses or values; their keys say in what."""
    text = json.dumps(sidecar(load(ROOT / "examples" / "learned_fast.toml").design))
    keys = set(re.findall(r'"(\w+)": -?\d+(?:\.|e)', text))
    assert len(keys) > 5
    assert all(key.endswith(("_m", "_pa", "_codes")) or key in ("lsb", "uncertainty_threshold") for key in keys)


def test_the_sidecar_alone_gives_the_values(tmp_path: Path) -> None:
    """docs/sidecar.md's program has nothing else."""
    code = (ROOT / "docs" / "sidecar.md").read_text().partition("```python\n")[2].partition("```")[0]
    (tmp_path / "core.json").write_text(json.dumps(sidecar(DESIGN)))
    program: dict[str, Any] = {}
    with contextlib.chdir(tmp_path):
        exec(code, program)
    words = DESIGN.model(contact_codes(DESIGN, 12, 3)).words
    known = decode(DESIGN, words)
    assert (words < 0).any()
    for number, frame in enumerate(words):
        told = program["values"]([int(word) & 0xFFFFFFFF for word in frame])
        np.testing.assert_allclose(told["resultant"], known.resultant[number], rtol=1e-12)
        np.testing.assert_allclose(told["forces"], known.forces[number].ravel(), rtol=1e-12)
        np.testing.assert_allclose(told["phi"], known.phi_deg[number], rtol=1e-12)
        assert told["status"] == [known.status[number]]


def test_the_hash_covers_every_choice() -> None:
    """Any other choice, coefficient or kind of image gives another hash; the same design has the same."""
    others = [
        replace(DESIGN, name="other"),
        replace(DESIGN, adc=Adc(9)),
        replace(DESIGN, search=Search(7)),
        replace(DESIGN, sensor=replace(DESIGN.sensor, thickness=2.9e-3)),
        replace(DESIGN, target="ice40"),
        replace(DESIGN, images="readmemh"),
    ]
    hashes = [sidecar(design)["configuration_sha256"] for design in (DESIGN, *others)]
    assert len(set(hashes)) == len(hashes)
    assert sidecar(replace(DESIGN))["configuration_sha256"] == hashes[0]
