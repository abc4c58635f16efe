"""The guarantees of every component in the registry."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from hmrsim.components import registry
from tests.simulation import simulate


@pytest.fixture(params=registry().values(), ids=registry())
def component(request):
    return request.param


def test_a_robot_can_carry_it_with_default_settings(component):
    run = simulate({"robots": {"wall_e": {"at": [0, 0], "components": {component.name: {}}}}})

    assert [component.name] == list(run.simulator.robots["wall_e"].components)


def test_it_rejects_unknown_settings(component):
    with pytest.raises(ValidationError, match="colour"):
        component.settings.model_validate({"colour": "red"})
