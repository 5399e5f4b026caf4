"""Frame sets come back as they were made, and nothing that is wrong with a folder goes unnoticed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from pydantic import ValidationError

from tests.study.definitions import LAYER, MIXTURE, SENSOR, complete, definition, section
from tests.study.frames.test_mixture import same
from tfra.codegen.config.complaints import complaint
from tfra.codegen.config.schema import Section
from tfra.runtime.errors import InputError
from tfra.study.frames.block import BLOCK, Part
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.frames.schema import FramesSection


@pytest.fixture
def stored(tmp_path: Path) -> FrameSet:
    return complete(tmp_path / "set", definition())


def file_of(frames: FrameSet, part: Part) -> Path:
    return frames.folder / f"{part}-000000.block"


def refused(frames: FrameSet, part: Part = Part.TRAIN) -> str:
    with pytest.raises(InputError) as caught:
        frames.block(part, 0)
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix(str(frames.folder))


def test_what_was_made_comes_back(stored):
    again = FrameSet(stored.folder, definition())
    for part in Part:
        (block,) = again.blocks(part)
        assert same(block, definition().make(part, 0))
        assert block.stress.dtype == np.float32
        assert len(block) == stored.definition.frames(part)
        assert block.to_parquet() == again.block(part, 0).to_parquet()
    assert again.missing() == []
    table = pl.read_parquet(file_of(stored, Part.TRAIN).read_bytes()[32:])
    assert {"force_x_n", "phi_deg", "half_x_m", "noisy_stress_pa", "share_of_force"} <= set(table.columns)
    assert table["stress_pa"].dtype == pl.Array(pl.Float32, SENSOR.taxels)


def test_the_same_bytes_in_any_order(tmp_path):
    wanted = definition(train=BLOCK + 1, held_out=2)
    one, two = complete(tmp_path / "one", wanted), FrameSet.create(tmp_path / "two", wanted)
    for block in reversed(two.missing()):
        two.write(block)
    assert contents(one.folder) == contents(two.folder)
    assert [(block.start, len(block)) for block in two.blocks(Part.TRAIN)] == [(0, BLOCK), (BLOCK, 1)]


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def test_a_block_of_another_set_or_place_is_noticed(stored, tmp_path):
    other = complete(tmp_path / "other", definition(seed=8))
    for foreign in (file_of(other, Part.TRAIN), file_of(stored, Part.HELD_OUT)):
        file_of(stored, Part.TRAIN).write_bytes(foreign.read_bytes())
        assert "is not as it was written" in refused(stored)


def test_a_missing_block_is_told_and_made_again(stored):
    file = file_of(stored, Part.TRAIN)
    data = file.read_bytes()
    file.unlink()
    assert refused(stored).endswith("train-000000.block: cannot be read: No such file or directory")
    assert stored.missing() == [(Part.TRAIN, 0)]
    complete(stored.folder, stored.definition)
    assert file.read_bytes() == data


OTHER = {
    "seed": definition(seed=8),
    "count": definition(train=41),
    "mixture": definition(MIXTURE.replace("from = -10", "from = -9")),
    "sensor": Definition.of(Path("study.toml"), replace(SENSOR, rows=7), LAYER, section()),
    "cover": Definition.of(Path("study.toml"), SENSOR, replace(LAYER, poisson=0.3), section()),
}


@pytest.mark.parametrize("change", OTHER)
def test_another_definition_has_other_frames(stored, change):
    other = FrameSet(stored.folder, OTHER[change])
    assert other != stored
    assert "is not as it was written" in refused(other)


def test_a_folder_that_is_none(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file: cannot be written"):
        FrameSet.create(tmp_path / "file", definition())
    with pytest.raises(InputError, match="cannot be read: No such file"):
        FrameSet(tmp_path / "nothing", definition()).missing()


def recording(folder: Path, **changes: int) -> Definition:
    frames = FramesSection(**{"train": 5, "held_out": 3, "recording": "r.npz", **changes})
    return Definition.of(folder / "study.toml", SENSOR, LAYER, frames)


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    stress = np.random.default_rng(1).normal(size=(9, 6, 8)) * 1e3
    forces = np.arange(27.0).reshape(9, 3)
    forces[8] = np.nan
    np.savez(tmp_path / "r.npz", frames=stress, resultant_ref=forces, mu_ref=np.arange(9.0))
    return tmp_path


def test_a_recording_from_both_ends(recorded):
    frames = complete(recorded / "set", recording(recorded))
    train, held_out = (frames.block(part, 0) for part in Part)
    stress = np.load(recorded / "r.npz")["frames"].astype(np.float32)
    assert np.array_equal(train.stress, stress[:5])
    assert np.array_equal(held_out.stress, stress[[8, 7, 6]])
    assert np.array_equal(train.noisy, train.stress)
    assert train.mu.tolist() == [0, 1, 2, 3, 4]
    np.testing.assert_array_equal(held_out.resultant, [[np.nan] * 3, [21, 22, 23], [18, 19, 20]])
    assert np.isnan(train.phi_deg).all()
    assert np.isnan(train.shares).all()


def test_a_recording_is_known_by_its_content(recorded):
    frames = FrameSet(recorded / "set", recording(recorded))
    (recorded / "elsewhere").mkdir()
    (recorded / "r.npz").rename(recorded / "elsewhere" / "r.npz")
    assert FrameSet(recorded, recording(recorded, recording="elsewhere/r.npz")) == frames
    stress = np.load(recorded / "elsewhere" / "r.npz")["frames"]
    stress[0, 0, 0] += 1
    np.savez(recorded / "r.npz", frames=stress)
    assert FrameSet(recorded / "set", recording(recorded)) != frames


def test_a_recording_that_is_too_short_or_missing(recorded):
    with pytest.raises(InputError, match=r"frames\.train: 10 frames with those of held_out are wanted, .* has 9"):
        recording(recorded, train=7)
    with pytest.raises(InputError, match=r"nothing\.npz: cannot be read"):
        recording(recorded, recording="nothing.npz")


class Document(Section):
    frames: FramesSection


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"mu": {"from": 0, "too": 1}}, 'mu.too: unknown key, the nearest valid key is "to"'),
        ({"mu": {"from": 0}}, "mu.to: is missing"),
        ({"mu": []}, "mu: at least one value is needed, got []"),
        ({"mu": [1, "a"]}, "mu#2: a number is needed, got 'a'"),
        ({"mu": float("inf")}, "mu: a finite number is needed, got inf"),
        ({"shape": ["hertz", 2]}, "shape#2: a text in quotes is needed, got 2"),
    ],
)
def test_form_is_complained_of_by_key(changes, line):
    content = section().model_dump(by_alias=True)
    with pytest.raises(ValidationError) as caught:
        Document.model_validate({"frames": content | {"mixture": [content["mixture"][0] | changes]}})
    assert ": ".join(complaint(caught.value, Document)) == f"frames.mixture#1.{line}"


def test_either_a_mixture_or_a_recording():
    for changes in ({"mixture": []}, {"recording": "r.npz"}):
        with pytest.raises(InputError, match=r"frames\.mixture: either this or a recording is needed"):
            definition(**changes)
    with pytest.raises(InputError, match=r"frames\.train: at least one frame"):
        definition(train=0, held_out=0)
