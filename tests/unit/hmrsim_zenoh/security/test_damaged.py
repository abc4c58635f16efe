"""Policies and enclave descriptions that were edited by hand lead to clear errors."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from hmrsim_zenoh.security.roles import Rights
from hmrsim_zenoh.wire.access_control import AccessControl
from hmrsim_zenoh.wire.enclave import Enclave, Member
from tests.profiles import examples
from tests.unit.hmrsim_zenoh.security.conftest import MEMBERS

POLICY = Rights("hmrsim", 0).access_control(MEMBERS).to_json()
JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["**", "a/b", "put"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


def _places(value, path=()):
    """Yield the places of a JSON value."""
    yield path
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield from _places(inner, (*path, key))


def _replaced(value, path, new):
    """Return a JSON value with one place replaced."""
    if not path:
        return new
    copy = dict(value) if isinstance(value, dict) else list(value)
    copy[path[0]] = _replaced(value[path[0]], path[1:], new)
    return copy


@examples(300)
@given(st.sampled_from(list(_places(POLICY))), JSON)
def test_a_damaged_policy_is_refused_or_decides(path, new):
    """Reading a damaged policy raises only ValueError, and a valid policy can be queried."""
    with suppress(ValueError):
        policy = AccessControl.from_json(_replaced(POLICY, path, new))
        assert policy.reads("hmrsim/_world/load_world") is not None
        for name in policy.rules:
            assert policy.may_query(name, "hmrsim/eve/wait/_action/send_goal") is not None
        AccessControl.from_json(policy.to_json())


def test_a_policy_that_people_have_changed_is_enforced_as_it_is(keystore):
    """Rules for both flows are whole; denial stays the default."""
    path = keystore.enclave("simulator").folder / "policy.json"
    changed = json.loads(path.read_text(encoding="utf-8")) | {"enabled": False, "default_permission": "allow"}
    changed["rules"][0]["flows"] = ["ingress", "egress"]
    path.write_text(json.dumps(changed), encoding="utf-8")
    enforced = keystore.enclave("simulator").session()["access_control"]

    assert changed | {"enabled": True, "default_permission": "deny"} == enforced


@examples(300)
@given(st.sampled_from(list(_places(MEMBERS[1].to_json()))), JSON)
def test_a_damaged_description_is_refused_or_read(path, new):
    """Reading a damaged enclave description raises only ValueError."""
    whole = {**MEMBERS[1].to_json(), "expires": "2030-01-01T00:00:00+00:00"}
    with suppress(ValueError):
        assert Enclave(Path(), Member.from_json(_replaced(whole, path, new))).left is not None
