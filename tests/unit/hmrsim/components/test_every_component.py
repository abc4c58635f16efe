"""What every component in the registry promises."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from hmrsim.components import registry
from tests.simulation import simulate


@pytest.fixture(params=registry().values(), ids=registry())
def component(request):
    """Return each component in turn."""
    return request.param


def test_it_can_be_carried_with_its_default_settings(component):
    """A world needs to name it only."""
    run = simulate({"robots": {"wall_e": {"at": [0, 0], "components": {component.name: {}}}}})

    assert [component.name] == list(run.simulator.robots["wall_e"].components)


def test_it_refuses_unknown_settings(component):
    """A slip in a world file is told."""
    with pytest.raises(ValidationError, match="colour"):
        component.settings.model_validate({"colour": "red"})
