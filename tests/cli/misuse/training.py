"""Cases of misuse of ``tfra train`` and of the folder with its state."""

from tests.cli.misuse.mistakes import Misuse, folder, nothing

TRAIN = "train skin.toml --out w.npz"
_OTHER = '{"generator": "tfra 0.0.1", "sources": "0123456789abcdef"}'

TRAINING = [
    Misuse("a training of no sensor", nothing, "train skln.toml --out w.npz"),
    Misuse("weights with another suffix", nothing, "train skin.toml --out w.h5"),
    Misuse("weights in a folder that is not there", nothing, "train skin.toml --out lab/w.npz"),
    Misuse("frames as the place of weights", nothing, "train skin.toml --out frames.npz"),
    Misuse("steps that are no number", nothing, f"{TRAIN} --steps many"),
    Misuse("no time at all", nothing, f"{TRAIN} --minutes 0"),
    Misuse("nan minutes", nothing, f"{TRAIN} --minutes nan"),
    Misuse("steps and minutes", nothing, f"{TRAIN} --steps 9 --minutes 9"),
    Misuse("a layer without units", nothing, f"{TRAIN} --channels 48 0"),
    Misuse("a training in a folder of notes", folder("notes", thesis_tex="years"), f"{TRAIN} --work notes"),
    Misuse("a training in the folder of a study", folder("bits", study_json=_OTHER), f"{TRAIN} --work bits"),
    Misuse("a training of another version", folder("old", training_json=_OTHER), f"{TRAIN} --work old"),
    Misuse("a file as the folder of a training", nothing, f"{TRAIN} --work frames.npz"),
]
