"""The guarantees of every service in the registry."""

from __future__ import annotations

import json

import pytest
from pydantic import ValidationError

from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.protocol.commands import CallService
from hmrsim.services import registry
from tests.simulation import simulate

WORLD = {
    "waypoints": {"here": [0, 0], "there": [10, 0], "upstairs": [100, 0]},
    "lanes": [["here", "there"]],
    "doors": {"gate": {"at": [[5, -1], [5, 1]]}},
    "lifts": {"lift": {"stops": ["there", "upstairs"]}},
    "items": {"parcel": {"at": [0, 0.5], "weight": 0.2}},
    "robots": {"tester": {"at": "here", "components": {"camera": {}}}},
}


@pytest.fixture(params=registry().values(), ids=registry())
def service(request):
    return request.param


def read(service, values):
    return service.request.model_validate_json(json.dumps(values))


@pytest.fixture
def answer(service):
    run = simulate(WORLD)
    run.simulator.submit(CallService(service.name, read(service, service.example), "asked"))
    return run.log.answer("asked")


def test_it_answers_its_example_at_once_and_once(service, answer):
    """The simulation is not paused, so step_simulation rejects its example."""
    assert isinstance(answer, service.response)
    if hasattr(answer, "result"):
        expected = Result.RESULT_OPERATION_FAILED if service.name == "step_simulation" else Result.RESULT_OK
        assert expected == answer.result.result, answer.result.error_message


def test_its_answer_survives_json(service, answer):
    assert answer == service.response.model_validate_json(answer.model_dump_json())


def test_an_empty_request_is_answered(service):
    run = simulate(WORLD)
    run.simulator.submit(CallService(service.name, read(service, {}), "asked"))

    assert isinstance(run.log.answer("asked"), service.response)


def test_an_unknown_field_is_rejected(service):
    with pytest.raises(ValidationError, match="Extra inputs are not permitted"):
        read(service, {"no_such_field": 1})


def test_its_ros_type_is_that_of_its_messages(service):
    assert [f"{service.ros_type}_{part}" for part in ("Request", "Response")] == [
        service.request.ros_type,
        service.response.ros_type,
    ]


def test_it_is_deterministic(service):
    logs = []
    for _ in range(2):
        run = simulate(WORLD)
        run.simulator.submit(CallService(service.name, read(service, service.example), "asked"))
        run.simulator.run()
        logs.append(run.log.events)

    assert logs[0] == logs[1]


def test_queries_publish_no_events(service):
    run = simulate(WORLD)
    run.simulator.submit(CallService(service.name, read(service, service.example), "asked"))

    assert service.changes_world or 1 == len(run.log.events)
