"""Disturbances of a controller and of its wire: what they are, and when they happen."""

from hmrsim.fault_search.disturbances.disturber import Acted, Disturber
from hmrsim.fault_search.disturbances.model import Disturbance, Kind

__all__ = ["Acted", "Disturbance", "Disturber", "Kind"]
