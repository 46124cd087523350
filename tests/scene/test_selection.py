"""Which of many are shown: both ends, evenly spread, each once."""

from r3gw.scene.selection import evenly


def test_evenly_takes_both_ends():
    assert evenly(range(10), 4) == [0, 3, 6, 9]
    assert evenly("ab", 5) == ["a", "b"]
    assert evenly(range(3), 1) == [0]
    assert evenly([], 4) == []
