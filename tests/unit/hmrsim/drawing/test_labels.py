"""Where names are put."""

from __future__ import annotations

from hmrsim.drawing.labels import Labels


def test_what_is_far_larger_than_the_picture_takes_all_of_it():
    """A radius in millimetres where metres were meant costs no more than one that fits."""
    labels = Labels((0.0, 0.0, 100.0, 100.0))
    labels.block((-1e9, -1e9, 1e9, 1e9))

    assert labels.place((50.0, 50.0), 2.0, 20.0, 10.0) is None


def test_what_is_beside_the_picture_takes_none_of_it():
    """A name is where it would be without."""
    labels = Labels((0.0, 0.0, 100.0, 100.0))
    before = labels.place((50.0, 50.0), 2.0, 20.0, 10.0)
    other = Labels((0.0, 0.0, 100.0, 100.0))
    other.block((200.0, 0.0, 300.0, 100.0))

    assert before == other.place((50.0, 50.0), 2.0, 20.0, 10.0)
