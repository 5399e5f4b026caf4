"""Windows of a schedule in literal numbers."""

from tfra.hdl.lib.schedule import later, once


def test_windows():
    assert list(once(4)) == [4]
    assert list(later(once(4), 3)) == [7]
    assert list(later(range(1, 4), 2)) == [3, 4, 5]
    assert later(range(2), 0) == range(2)
