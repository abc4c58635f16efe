"""The model of a disturbance."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from hmrsim.trials.disturbances import Disturbance
from tests.cases import case

PICKUP = {"goal": "executing", "robot": "eve", "action": "pickup", "after": 0.5}


def disturbance(kind, **more):
    return Disturbance.model_validate({"disturbance": kind, "when": PICKUP, **more})


def test_describes_disturbances_in_words():
    for made, text in [
        (disturbance("controller_killed"), "the controller is killed"),
        (disturbance("controller_killed", restart_after=5), "the controller is killed, and started again after 5 s"),
        (disturbance("controller_stalled", duration=20), "the controller is stalled for 20 s"),
        (disturbance("second_controller"), "a second controller is started"),
        (disturbance("reply_lost"), "the next answer is lost"),
        (disturbance("request_repeated", count=3), "the next 3 requests come twice"),
        (disturbance("simulation_reset"), "the simulation is reset"),
    ]:
        with case(text):
            assert f"{text}: 0.5 s after pickup of eve is executing" == made.describe()


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"disturbance": "controller_killed", "duration": 5}, "duration belongs to controller_stalled"),
        ({"disturbance": "controller_stalled"}, "needs a duration"),
        ({"disturbance": "second_controller", "count": 2}, "count belongs to reply_lost and request_repeated"),
        ({"disturbance": "simulation_reset", "restart_after": 2}, "restart_after belongs to controller_killed"),
        ({"disturbance": "reply_lost", "count": 0}, "greater than or equal to 1"),
        ({"disturbance": "power_cut"}, "controller_killed"),
    ],
)
def test_rejects_settings_of_other_kinds(settings, why):
    with pytest.raises(ValidationError, match=why):
        Disturbance.model_validate({"when": PICKUP, **settings})


def test_survives_a_round_trip_through_json():
    made = disturbance("controller_killed", restart_after=5)

    assert made == Disturbance.model_validate_json(made.model_dump_json(exclude_unset=True))


def test_unknown_kind_of_event_is_a_flaw():
    made = Disturbance.model_validate({"disturbance": "simulation_reset", "when": {"event": "picked_up"}})

    assert [("when", "event")] == [finding.path for finding in made.flaws()]
