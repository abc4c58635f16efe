"""The text formats of ports."""

from __future__ import annotations

import copy

import pytest

from bt_controller.core.ports import PLANNER, POSE, UNSIGNED, Given


class _Nowhere:
    """Places of which there is none."""

    def pose(self, name):
        """Raise an error that names the place."""
        raise ValueError(f"no place {name!r}; there are none")


def test_an_unknown_given_place_is_reported_as_it_was_given():
    """The place was given with --set; the simulator knows the places."""
    with pytest.raises(ValueError, match=r"^--set goal=nowhere: no place 'nowhere'; there are none$"):
        POSE.read(Given("nowhere", "goal"), _Nowhere())


def test_a_given_text_can_be_copied():
    """A snapshot of a blackboard copies its values."""
    twin = copy.deepcopy(Given("ward", "goal"))

    assert ("ward", "goal") == (twin, twin.key)


def test_a_text_without_effect_here_is_doubted():
    """As that of a planner that no robot serves; one that is served, or of another kind, is not."""
    assert "no robot serves 'Smac'; there are GridBased, graph" == PLANNER.doubt("Smac")
    assert (None, None) == (PLANNER.doubt("graph"), UNSIGNED.doubt("3"))
