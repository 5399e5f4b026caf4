"""A small sensor with weights of no meaning."""

import numpy as np

from bench.accuracy.scenes import Case
from tests.model.learned.random_weights import random_weights
from tfra.model.choices import Adc
from tfra.model.cover.scenes import random_contacts
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(4, 5, 4e-3, 3e-3, 3e-3)


def random_case(name: str = "small") -> Case:
    rng = np.random.default_rng(0)
    weights = random_weights(rng, SENSOR.taxels, 3, 2)
    design = LearnedDesign(sensor=SENSOR, adc=Adc(14, 100e3), weights=weights, threshold=0.5, taxel_forces=False)
    return Case(name, design, tuple(random_contacts(SENSOR, 6, rng)))
