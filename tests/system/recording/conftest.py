"""Recordings and processes, as in the tests without a network."""

from tests.unit.hmrsim_zenoh.recording.conftest import record, start  # noqa: F401
