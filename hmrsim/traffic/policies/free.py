"""Robots pass through each other, and no robot waits for another."""

from __future__ import annotations

from hmrsim.traffic.policies import Policy, Settings

POLICY = Policy(name="free", settings=Settings, rule=None)
