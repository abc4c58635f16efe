"""Disturbances of a controller and of its wire: what they are, and when they happen."""

from hmrsim.trials.disturbances.disturber import Acted, Disturber
from hmrsim.trials.disturbances.model import Disturbance, Kind

__all__ = ["Acted", "Disturbance", "Disturber", "Kind"]
