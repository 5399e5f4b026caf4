"""What may be searched, and the design that a point makes."""

from dataclasses import replace

import pytest

from tests.model.cases import make_design
from tfra.model.choices import FORMATS, Search
from tfra.model.cover.scenes import SENSORS
from tfra.study.search.space import Space, names

BASE = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])


def test_a_point_changes_what_it_names() -> None:
    space = Space({"coefficient": (12, 14), "operand.force": (10, 16), "mac_lanes": (4, 8), "steps": (50, 100)})
    point = space.point({"coefficient": 1, "operand.force": 0, "mac_lanes": 1, "steps": 0})
    assert point == {"coefficient": 14, "operand.force": 10, "mac_lanes": 8, "steps": 50}
    design = space.design(BASE, point)
    formats = replace(FORMATS["standard"], name="custom", coefficient=14, signals=(("operand.force", 10),))
    architecture = replace(BASE.architecture, mac_lanes=8)
    assert design == replace(BASE, formats=formats, architecture=architecture, search=Search(50))


def test_a_signal_of_the_base_stays() -> None:
    base = replace(BASE, formats=replace(BASE.formats, signals=(("sums", 20), ("operand.force", 12))))
    design = Space({"operand.force": (14,)}).design(base, {"operand.force": 14})
    assert dict(design.formats.signals) == {"sums": 20, "operand.force": 14}


@pytest.mark.parametrize("name", names(BASE))
def test_every_name_is_a_choice(name: str) -> None:
    values = {"mac_lanes": 8, "vector_words": 2, "vector_fraction": 8, "force_fraction": 3}
    values |= {"cordic": 26, "division": 27}
    value = values.get(name, 18)
    changed = Space({name: (value,)}).design(replace(BASE, formats=replace(FORMATS["wide"])), {name: value})
    assert changed != replace(BASE, formats=replace(FORMATS["wide"], name="custom"))


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({}, "space: at least one name to choose is needed"),
        ({"operand.forces": (1,)}, "operand.forces: unknown signal, the nearest is operand.force"),
        ({"steps": ()}, r"steps: options in rising order are needed, got \[\]"),
        ({"steps": (2, 1)}, r"steps: options in rising order are needed, got \[2, 1\]"),
        ({"steps": (1, 1)}, r"steps: options in rising order are needed, got \[1, 1\]"),
    ],
)
def test_spaces_that_are_none(options: dict[str, tuple[int, ...]], line: str) -> None:
    with pytest.raises(ValueError, match=f"^{line}$"):
        Space(options).require_of(BASE)


@pytest.mark.parametrize(
    ("point", "line"),
    [
        ({"mac_lanes": 9}, "architecture.mac_lanes: a multiple of 4"),
        ({"cordic": 12}, "signals.cordic: at least 18 bits"),
    ],
)
def test_choices_that_do_not_fit_say_why(point: dict[str, int], line: str) -> None:
    with pytest.raises(ValueError, match=f"^{line}"):
        Space({name: (value,) for name, value in point.items()}).design(BASE, point)
