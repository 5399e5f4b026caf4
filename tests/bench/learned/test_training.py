"""The table of held-out errors is that of the files of weights that are kept."""

from __future__ import annotations

import json

import pytest

from bench.learned.training import CONFIGS, figures, table, trained
from bench.publish import ROOT


@pytest.mark.parametrize("config", CONFIGS)
def test_the_record_is_that_of_the_weights(config: str) -> None:
    record = json.loads((ROOT / "bench" / "results" / "training.json").read_text())
    now = json.loads(json.dumps(figures(trained(config))))
    assert record[config].keys() == now.keys()
    for key, value in now.items():
        if key == "flagged_percent":
            assert record[config][key] == pytest.approx(value, abs=0.2)  # weights in a file are rounded
        else:
            assert record[config][key] == value
    assert now["flagged_percent"]["0.001"] == pytest.approx(2.0, abs=1.5)
    assert (ROOT / config).with_suffix(".weights.npz").stat().st_size < 200_000


def test_the_page_shows_the_record() -> None:
    record = json.loads((ROOT / "bench" / "results" / "training.json").read_text())
    assert tuple(record) == CONFIGS
    shown = table(record)
    assert len(shown.splitlines()) == 2 + 3 * len(CONFIGS)
    assert shown in (ROOT / "docs" / "training.md").read_text()
    record[CONFIGS[0]]["held_out"]["mu_50_at_0.001"] += 0.01
    assert table(record) not in (ROOT / "docs" / "training.md").read_text()
