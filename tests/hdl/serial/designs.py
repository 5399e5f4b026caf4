"""Designs that the tests of the serial core share."""

import random
from typing import Any

from tests.model.fixed.learned.cases import learned_design
from tfra.model.choices import FORMATS, SERIAL, Adc, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray


def tfra(*sensor: Any, **choices: Any) -> TfraDesign:
    return TfraDesign(SensorArray(*sensor), architecture=SERIAL, **choices)


DESIGNS = {
    "2×3": tfra(2, 3, 2e-3, 3e-3, 2e-3, search=Search(5)),
    "3×4": tfra(3, 4, 4e-3, 2e-3, 3e-3, adc=Adc(contact_threshold=0), search=Search(10)),
    "5×7, tolerance": tfra(5, 7, 3e-3, 3e-3, 2e-3, search=Search(16, 2.5)),
    "wide": tfra(
        3, 5, 1.27e-3, 2.54e-3, 2e-3,
        adc=Adc(16, contact_threshold=1024), search=Search(9, 2.5), formats=FORMATS["wide"],
    ),
    "short": tfra(4, 4, 4e-3, 2.5e-3, 3e-3, adc=Adc(8), search=Search(1), formats=Formats("short", 10, 10, 16, 3)),
    "long": tfra(4, 6, 5e-3, 3e-3, 2e-3, adc=Adc(6), search=Search(33), formats=Formats("long", 18, 27, 0, 0)),
}  # fmt: skip

LEARNED = {
    "2×2": learned_design(2, 2, (1, 1), architecture=SERIAL, threshold=300.0),
    "2×3, forces": learned_design(2, 3, (3, 2), seed=1, architecture=SERIAL),
    "3×5": learned_design(3, 5, (7, 4), seed=2, architecture=SERIAL, taxel_forces=False),
    "5×7, forces": learned_design(5, 7, (6, 13), seed=3, architecture=SERIAL, threshold=1.5),
    "wide": learned_design(4, 3, (4, 2), seed=4, architecture=SERIAL, adc=Adc(16), formats=FORMATS["wide"]),
    "short": learned_design(
        3, 3, (5, 3), seed=5, architecture=SERIAL, adc=Adc(8), formats=Formats("short", 12, 14, 16, 3)
    ),
    "long": learned_design(
        4, 6, (2, 9), seed=6, architecture=SERIAL, adc=Adc(6), formats=Formats("long", 18, 27, 0, 0)
    ),
}
"""Designs of the learned estimator; orbits of units vary in number with the quads."""

LEARNED_TEN = learned_design(10, 10, (48, 24), architecture=SERIAL, adc=Adc(), taxel_forces=False)
"""The learned design that has to fit an iCE40UP5K."""


def random_design(seed: int) -> Design:
    """Any small array, any contact threshold."""
    rng = random.Random(seed)
    rows, columns = rng.randrange(2, 9), rng.randrange(2, 9)
    pitch = [rng.choice([1.27e-3, 2e-3, 4e-3]) for _ in range(2)]
    steps = rng.choice([1, 7, 12, 63])
    adc = Adc(contact_threshold=rng.choice([None, 0, rng.randrange(2000)]))
    return tfra(rows, columns, *pitch, 3e-3, adc=adc, search=Search(steps))


TEN = tfra(10, 10, 4e-3, 2e-3, 3e-3)
"""The design that has to fit an iCE40UP5K."""
