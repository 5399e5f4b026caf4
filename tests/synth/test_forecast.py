"""Time left, by a clock in the hand."""

from __future__ import annotations

import pytest

from tfra.synth.forecast import BITSTREAM, YOSYS, Forecast, seed_name, spoken


class Clock:
    """Seconds that a test says."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def forecast(clock: Clock) -> Forecast:
    """Two seeds, with round numbers."""
    found = Forecast(clock)
    found.plan(1000, 2)
    found.expected = {YOSYS: 10.0, seed_name(1): 40.0, seed_name(2): 40.0, BITSTREAM: 1.0}
    return found


def test_before_anything_is_known() -> None:
    found = Forecast(Clock())
    assert (found.share, found.left, found.expected) == (0.0, 0.0, {})


def test_steps_as_expected() -> None:
    clock = Clock()
    found = forecast(clock)
    found.begin(YOSYS)
    assert (found.left, found.share) == (91.0, 0.0)
    clock.now += 5
    assert found.left == 86.0
    clock.now += 5
    found.begin(seed_name(1))
    assert found.left == 81.0
    clock.now += 20
    assert found.share == pytest.approx(30 / 91)
    assert str(found) == "place and route, seed 1: 33 %, about 61 s left"


def test_a_slow_machine_corrects_what_follows() -> None:
    clock = Clock()
    found = forecast(clock)
    found.begin(YOSYS)
    clock.now += 30
    found.begin(seed_name(1))
    assert found.left == pytest.approx(3 * 81)
    clock.now += 60
    found.begin(seed_name(2))
    assert found.left == pytest.approx(60 + 1.5)


def test_kept_steps_say_nothing_of_the_machine() -> None:
    clock = Clock()
    found = forecast(clock)
    found.begin(YOSYS)
    found.kept.add(YOSYS)
    clock.now += 0.1
    found.begin(seed_name(1))
    assert found.left == 81.0


def test_a_step_without_an_end_never_ends() -> None:
    clock = Clock()
    found = forecast(clock)
    found.begin(BITSTREAM)
    shares = []
    for _ in range(5):
        clock.now *= 10
        shares.append(found.share)
    assert max(shares) < 1.0


def test_larger_cores_take_longer() -> None:
    small, large = Forecast(), Forecast()
    small.plan(1000, 3)
    large.plan(20_000, 3)
    assert small.expected.keys() == large.expected.keys()
    assert all(small.expected[step] < large.expected[step] for step in small.expected)
    small.plan(1000, 0)
    assert set(small.expected) == {YOSYS}


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.0, "1 s"), (89.4, "89 s"), (90.0, "2 min"), (5399.0, "90 min"), (5400.0, "1.5 h")]
)
def test_times_in_words(seconds: float, said: str) -> None:
    assert spoken(seconds) == said
