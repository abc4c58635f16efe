"""The settings of a run, as a program gives them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hmrsim.settings.option import settings_of
from hmrsim.settings.run import DemoSettings, RunSettings, SimulateSettings
from hmrsim_zenoh.settings import SERVED


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"real_time_factor": -1.0}, "-1 is less than 0"),
        ({"real_time_factor": 1e7}, "1e[+]07 is greater than 1e[+]06; 0 is as fast as possible"),
        ({"real_time_factor": math.nan}, "'nan' is not a finite number"),
        ({"feedback_rate": 0.0}, "0 is not greater than 0"),
        ({"step_size": 5e-10}, "5e-10 s is less than a nanosecond"),
        ({"participants": 0}, "0 is not greater than 0"),
        ({"participants": ()}, "'' is neither a number nor names"),
        ({"participants": ("a nurse",)}, "'a nurse' is neither a number nor names"),
        ({"result_timeout": -2.0}, "-2 is less than 0; -1 is for ever"),
        ({"participant_timeout": 0.0}, "0 is not greater than 0"),
        ({"seed": 1.5}, "valid integer"),
        ({"seed": True}, "valid integer"),
        ({"keep_results": "10"}, "valid integer"),
        ({"clock": "sundial"}, "'realtime' or 'lockstep'"),
        ({"hold": 1.0}, "not permitted"),
    ],
)
def test_an_invalid_setting_is_rejected(fields, why):
    """An invalid setting is rejected with its name, its value and a remedy."""
    with pytest.raises(ValidationError, match=why):
        RunSettings(**fields)


def test_settings_do_not_change():
    """The settings of a run are immutable."""
    with pytest.raises(ValidationError, match="frozen"):
        RunSettings().seed = 3


@pytest.mark.parametrize("name", ["participant_timeout", "planner_timeout"])
def test_minus_one_is_for_ever(name):
    """A timeout of -1 or infinity never ends, as on the command line."""
    assert math.inf == getattr(RunSettings(**{name: -1}), name) == getattr(RunSettings(**{name: math.inf}), name)


def test_names_of_participants_are_unique():
    """Names of participants can be a list, and duplicates are dropped."""
    assert ("nurses", "porters") == RunSettings(participants=["nurses", "porters", "nurses"]).participants


@pytest.mark.parametrize("model", [*SERVED, SimulateSettings, DemoSettings])
def test_every_setting_says_what_it_is(model):
    """Every setting has a description and a valid default."""
    for setting in settings_of(model).values():
        option = setting.option
        assert option.help
        assert not option.help.endswith(".")
        assert setting.default is None or setting.default == option.checked(setting.default)


def test_no_setting_is_in_two_models():
    """No setting is declared twice, as a settings file has one key for each."""
    names = [name for model in SERVED for name in settings_of(model)]

    assert sorted(set(names)) == sorted(names)


@given(st.floats())
def test_a_factor_is_what_its_bounds_say(value):
    """A real-time factor is valid exactly within its bounds."""
    allowed = value == 0 or 1e-6 <= value <= 1e6
    try:
        factor = RunSettings(real_time_factor=value).real_time_factor
    except ValidationError:
        assert not allowed
    else:
        assert allowed
        assert value == factor
