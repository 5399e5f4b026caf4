"""Cases of misuse of ``tfra train`` and of the folder with its state."""

from __future__ import annotations

from tests.cli.misuse.mistakes import Misuse, folder, nothing

TRAIN = "train skin.toml --out w.npz"
_OTHER = '{"generator": "tfra 0.0.1", "sources": "0123456789abcdef"}'

TRAINING = [
    Misuse("a training of no sensor", nothing, "train skln.toml --out w.npz", "skln.toml: cannot be read"),
    Misuse("weights with another suffix", nothing, "train skin.toml --out w.h5", "must end in .npz"),
    Misuse("weights in a folder that is not there", nothing, "train skin.toml --out lab/w.npz", "cannot be written"),
    Misuse(
        "frames as the place of weights",
        nothing,
        "train skin.toml --out frames.npz",
        "frames.npz: is not replaced: tfra frames wrote it, not tfra train",
    ),
    Misuse("steps that are no number", nothing, f"{TRAIN} --steps many", "Invalid value for '--steps'"),
    Misuse("no time at all", nothing, f"{TRAIN} --minutes 0", "Invalid value for '--minutes'"),
    Misuse("nan minutes", nothing, f"{TRAIN} --minutes nan", "Invalid value for '--minutes'"),
    Misuse("steps and minutes", nothing, f"{TRAIN} --steps 9 --minutes 9", "--minutes: and --steps exclude each other"),
    Misuse("a layer without units", nothing, f"{TRAIN} --channels 48 0", "Invalid value for '--channels'"),
    Misuse(
        "a training in a folder of notes",
        folder("notes", thesis_tex="years"),
        f"{TRAIN} --work notes",
        "notes: is not the folder of a training",
    ),
    Misuse(
        "a training in the folder of a study",
        folder("bits", study_json=_OTHER),
        f"{TRAIN} --work bits",
        "bits: is not the folder of a training",
    ),
    Misuse(
        "a training of another version",
        folder("old", training_json=_OTHER),
        f"{TRAIN} --work old",
        "old: has work of tfra 0.0.1 with other sources",
    ),
    Misuse("a file as the folder of a training", nothing, f"{TRAIN} --work frames.npz", "frames.npz: cannot be"),
]
