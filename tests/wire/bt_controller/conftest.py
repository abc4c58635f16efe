"""Fixtures of the tests of trees, with or without a simulator."""

from tests.unit.bt_controller.conftest import _clean_blackboard, client  # noqa: F401
