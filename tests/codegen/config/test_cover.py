"""What the simulation of a cover may cost."""

import re

import pytest

from tfra.codegen.config.cover import MOST_ELEMENTS, LayerSpec, require_few_modes
from tfra.model.cover.contact import Contact
from tfra.model.cover.fem import Mesh
from tfra.model.cover.layer import ElasticLayer, _modes
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(10, 10, 4e-3, 2e-3, 3e-3)
CONTACT = Contact("hertz", 0.018, 0.009, 0.008, 0.004, -5.0, 0.5, 0.0)


@pytest.mark.parametrize("element", [1e-12, 1e-9, 1e-5, 1.2e-4])
def test_meshes_too_large(element: float) -> None:
    """The line tells a length that works, and one a tenth shorter does not."""
    with pytest.raises(ValueError, match=r"^layer\.element_mm: .* elements, at most 50,000 are supported: ") as caught:
        LayerSpec(0.48, "point", "fem", element).frames(SENSOR, [CONTACT])
    found = re.search(r"([\d.]+) mm works$", str(caught.value))
    assert found
    works = float(found[1]) / 1e3
    assert Mesh(works).elements(SENSOR, CONTACT) <= MOST_ELEMENTS < Mesh(0.9 * works).elements(SENSOR, CONTACT)


def test_no_mesh_is_small_enough() -> None:
    thin = SensorArray(10, 10, 4e-3, 2e-3, 1e-5)
    with pytest.raises(ValueError, match=r'elements, at most 50,000 are supported: solver = "series" works$'):
        LayerSpec(0.48, "point", "fem", 4e-6).frames(thin, [CONTACT])


def test_modes_are_counted_without_computing_them() -> None:
    for size in (1e-3, 7e-3, 40e-3):
        layer = ElasticLayer(size, 20e-3, 3e-3, 0.48, 0.0, 0.0)
        assert layer.modes == _modes(layer).normal.size


def test_series_that_do_not_end() -> None:
    require_few_modes(ElasticLayer.under(SensorArray(64, 64, 4e-3, 4e-3, 3e-3)))
    with pytest.raises(ValueError, match=r"^thickness_mm: a cover this thin takes [\d,]+ modes of its series, at most"):
        require_few_modes(ElasticLayer.under(SensorArray(64, 64, 0.1, 0.1, 1e-3)))
    assert ElasticLayer.under(SensorArray(2, 2, 1e-6, 1e-6, 1.0)).modes < 100  # a million times as high as wide
