"""The spelling of the wildcards that a server declares."""

from __future__ import annotations

import zenoh
from hypothesis import given
from hypothesis import strategies as st

from hmrsim_zenoh.wire.keys import Keys, Verb, servers_own

CHUNKS = st.sampled_from(("hmrsim", "robot_1", "*", "**", "odom", "_action"))
PATTERNS = st.lists(CHUNKS, min_size=1, max_size=6).map("/".join).map(zenoh.KeyExpr.autocanonize).map(str)


@given(PATTERNS)
def test_it_includes_what_the_first_one_includes(pattern):
    """The server hears of each key that it would have heard of."""
    assert zenoh.KeyExpr(servers_own(pattern)).includes(zenoh.KeyExpr(pattern.replace("**", "a/b")))


def test_no_client_spells_it_so():
    """Zenoh would keep what it knows of the client."""
    keys = Keys()
    for pattern in (keys.everything(), keys.history(), keys.any_topic("odom"), keys.any_action(Verb.FEEDBACK)):
        assert servers_own(pattern) != pattern
    assert servers_own("0/*/tf/*/*") == "0/*/$*tf/*/*"


def test_what_has_no_other_spelling_stays():
    """A key without wildcards is one of those that Zenoh forgets by itself."""
    for key in ("hmrsim/_world/clock", "hmrsim/*", "*/*"):
        assert servers_own(key) == key


def test_other_prefixes_are_not_included():
    """A subscriber of another simulator's robots, even below this prefix, does not count for this one."""
    own = zenoh.KeyExpr(servers_own(Keys("site/one").any_topic("odom")))
    for other in ("site/one/deck/robot_1/odom", "site/two/robot_1/odom"):
        assert not own.intersects(zenoh.KeyExpr(other))
