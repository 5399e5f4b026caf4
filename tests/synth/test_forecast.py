"""Time left, by a clock in the hand."""

import pytest

from tfra.synth.forecast import BITSTREAM, YOSYS, Forecast, seed_name, spoken


class Clock:
    """Seconds that a test says."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def forecast(clock: Clock) -> Forecast:
    """Two seeds, with round numbers; yosys runs."""
    found = Forecast(clock)
    assert str(found) == "estimating: 0 %, about 1 s left"
    found.expected = {YOSYS: 10.0, seed_name(1): 40.0, seed_name(2): 40.0, BITSTREAM: 1.0}
    found.begin(YOSYS)
    return found


def test_steps_as_expected(forecast: Forecast, clock: Clock) -> None:
    assert forecast.left == 91.0
    clock.now += 10
    forecast.begin(seed_name(1))
    assert forecast.left == 81.0
    clock.now += 20
    assert str(forecast) == "place and route, seed 1: 33 %, about 61 s left"


def test_a_slow_machine_corrects_what_follows(forecast: Forecast, clock: Clock) -> None:
    clock.now += 30
    forecast.begin(seed_name(1))
    assert forecast.left == pytest.approx(3 * 81)
    clock.now += 60
    forecast.begin(seed_name(2))
    assert forecast.left == pytest.approx(60 + 1.5)


def test_the_cache_says_nothing_of_the_machine(forecast: Forecast, clock: Clock) -> None:
    forecast.cached = True
    clock.now += 0.1
    forecast.begin(seed_name(1))
    assert forecast.left == 81.0
    clock.now += 80
    forecast.begin(seed_name(2))
    assert forecast.left == 2 * 41


def test_a_step_without_an_end_never_ends(forecast: Forecast, clock: Clock) -> None:
    forecast.expected = {BITSTREAM: 1.0}
    forecast.begin(BITSTREAM)
    clock.now *= 1e5
    assert "bitstream: 91 %" in str(forecast)


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
