"""Cases of misuse of the learned estimator and its file of weights."""

from pathlib import Path

import numpy as np

from tests.cli.misuse.mistakes import CONFIG, Make, Misuse, config
from tfra.codegen.config.weights import Trained, write_weights
from tfra.model.learned.network import Weights
from tfra.model.sensor import SensorArray

ESTIMATOR = '[estimator]\nkind = "learned"\nweights = "w.npz"\n'
FLOAT = "estimate wrong.toml frames.npz --out r.npz"


def weights(pitch: float = 4e-3, keep: float = 1.0, flipped: bool = False) -> Make:
    """Make weights for CONFIG's sensor with another ``pitch`` along x in m; ``keep`` the beginning, change a bit."""

    def make() -> None:
        Path("wrong.toml").write_text(CONFIG.replace("[[contact]]", f"{ESTIMATOR}[[contact]]"))
        shapes = (2, 30), (4, 1, 2), (4, 1), (4, 2), (4, 30)
        learned = Weights(*(np.ones(shape) for shape in shapes))
        write_weights("w.npz", Trained(SensorArray(5, 6, pitch, 4e-3, 3e-3), learned, 0.25))
        content = bytearray(Path("w.npz").read_bytes())
        content[len(content) // 2] ^= flipped
        Path("w.npz").write_bytes(content[: int(keep * len(content))])

    return make


LEARNED = [
    Misuse(
        "a learned estimator without weights",
        config("[[contact]]", '[estimator]\nkind = "learned"\n[[contact]]'),
        FLOAT,
    ),
    Misuse("weights that are not there", config("[[contact]]", f"{ESTIMATOR}[[contact]]"), FLOAT),
    Misuse("weights of another sensor", weights(pitch=3e-3), FLOAT),
    Misuse("weights that end early", weights(keep=0.9), FLOAT),
    Misuse("weights with a changed bit", weights(flipped=True), FLOAT),
]
