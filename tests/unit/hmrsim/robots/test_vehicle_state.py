"""The table of a vehicle's transitions."""

from __future__ import annotations

from itertools import product

import pytest

from hmrsim.robots.vehicle_state import TRANSITIONS, IllegalTransition, VehicleEvent, VehicleState, next_state


def test_each_state_stands_moves_or_waits():
    assert {1} == {state.stands + state.moves + state.waits for state in VehicleState}


@pytest.mark.parametrize("event", VehicleEvent)
def test_events_follow_the_table_and_others_are_refused(event):
    for state in VehicleState:
        if (state, event) in TRANSITIONS:
            assert TRANSITIONS[state, event] is next_state(state, event)
        else:
            with pytest.raises(IllegalTransition, match=f"{event.value} is illegal .* {state.value}"):
                next_state(state, event)


def test_every_state_can_be_reached_and_left():
    reached = {VehicleState.IDLE}
    for _ in VehicleState:
        reached |= {after for (state, _), after in TRANSITIONS.items() if state in reached}
    back = {VehicleState.IDLE}
    for _ in VehicleState:
        back |= {state for (state, _), after in TRANSITIONS.items() if after in back}

    assert (set(VehicleState), set(VehicleState)) == (reached, back)


def test_only_moving_and_waiting_states_can_be_halted():
    for state, event in product(VehicleState, [VehicleEvent.HALT]):
        assert ((state, event) in TRANSITIONS) is not state.stands


def test_only_a_vehicle_that_stands_is_disabled_and_only_enabling_frees_it():
    before = {state for state, event in TRANSITIONS if event is VehicleEvent.DISABLE}
    after = {event for (state, event), to in TRANSITIONS.items() if state is VehicleState.DISABLED and to is not state}

    assert all(state.stands for state in before)
    assert {VehicleEvent.ENABLE} == after
