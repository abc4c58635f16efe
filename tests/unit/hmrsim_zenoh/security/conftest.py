"""A keystore of a hospital."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.security.keystore import Keystore, Network, own_hosts
from hmrsim_zenoh.wire.enclave import SIMULATOR, Member

MEMBERS = (
    Member(SIMULATOR, SIMULATOR),
    Member("nurses", "controller", ("wall_e", "eve"), ("call_lift",)),
    Member("fleet", "controller"),
    Member("viewer", "viewer"),
    Member("operator", "operator"),
)


@pytest.fixture
def keystore(tmp_path):
    """Return a new keystore."""
    return Keystore.create(tmp_path / "keys", MEMBERS, Network(hosts=own_hosts()))
