"""Designs of a search's front."""

from tfra.study.designs import front
from tfra.study.search.evaluate import CHANGE
from tfra.study.search.trials import COMPLETE, STOPPED, Trial


def trials(*points: tuple[float, float]) -> list[Trial]:
    """Complete trials by cost and error."""
    return [
        Trial(number, COMPLETE, {}, {"DSP": cost, CHANGE: change})
        for number, (cost, change) in enumerate(points)
    ]


def test_the_front_is_what_nothing_is_better_than() -> None:
    some = trials((10, 9.0), (10, 8.0), (20, 8.0), (30, 2.0), (40, 3.0), (50, 1.0), (60, 0.5))
    stopped = [Trial(9, STOPPED, {}, {"DSP": 1.0, CHANGE: 0.1})]
    numbers = {name: trial.number for name, trial in front([*some, *stopped], "DSP", 9).items()}
    assert numbers == {"front_1": 1, "front_2": 3, "front_3": 5, "front_4": 6}
    assert [trial.number for trial in front(some, "DSP", 2).values()] == [1, 6]
    assert front(some, "DSP", 0) == {}
    assert front([], "DSP", 3) == {}
