"""README and package say of TFRA's friction what the study of errors found."""

import json

import pytest

from bench.contacts import truth
from bench.publish import ROOT
from tfra.model.truth import medians, sentence


def block(name, page="README.md"):
    """What stands between the marks of a page."""
    _, _, rest = (ROOT / page).read_text().partition(f"<!-- {name} -->\n")
    text, mark, _ = rest.partition(f"\n<!-- end {name} -->")
    assert mark, f"<!-- {name} --> is missing in {page}"
    return text


def test_the_package_has_the_medians_of_the_study():
    assert json.loads((ROOT / "model" / "truth.json").read_text()) == truth.medians(truth.rows())
    assert medians() == {"0.3": 0.046, "0.5": 0.438, "0.7": 0.902}


def test_pages_say_it():
    assert " ".join(block("truth").split()) == f"- {sentence()}"
    assert block("right", "docs/measured.md") == truth.table(truth.rows())


def test_other_results_change_every_place(tmp_path, monkeypatch):
    for name in ("README.md", "docs/measured.md", "model/truth.json", "bench/results/errors.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    study = tmp_path / "bench" / "results" / "errors.json"
    content = json.loads(study.read_text())
    content["results"]["friction"]["random"]["0.3"]["mu_found"] = [0.1, 0.22, 0.31]
    study.write_text(json.dumps(content))
    monkeypatch.setattr(truth, "ROOT", tmp_path)
    monkeypatch.setattr("bench.publish.ROOT", tmp_path)
    truth.main()
    assert json.loads((tmp_path / "model" / "truth.json").read_text())["mu_found"]["0.3"] == 0.22
    assert "| 0.22 (0.10–0.31) |" in (tmp_path / "docs" / "measured.md").read_text()
    with pytest.raises(AssertionError, match="nowhere"):
        block("nowhere")
