"""Hypothesis profiles: few examples locally, reproducible ones in CI, and many at night.

The profile is that in ``HYPOTHESIS_PROFILE``: ``dev``, ``ci`` or ``nightly``; ``ci`` where ``CI`` is set.
"""

from __future__ import annotations

import os
from typing import Final

from hypothesis import HealthCheck, settings

SHARES: Final = {"dev": 0.5, "ci": 0.5, "nightly": 20.0}
"""The factor by which a profile multiplies the number of examples."""

PROFILE: Final = os.environ.get("HYPOTHESIS_PROFILE") or ("ci" if os.environ.get("CI") else "dev")

# Only the number of examples is limited, since a busy machine must not fail a test.
_TOLERATED: Final = (HealthCheck.too_slow,)


def examples(count: int, *, share_fixtures: bool = False) -> settings:
    """Return the settings of a test that tries *count* examples, or its share of them.

    Args:
        count: How many.
        share_fixtures: Whether the test's own fixtures may be the same ones for all examples.
    """
    tolerated = (*_TOLERATED, HealthCheck.function_scoped_fixture) if share_fixtures else _TOLERATED
    return settings(max_examples=max(1, round(count * SHARES[PROFILE])), suppress_health_check=tolerated)


def load() -> None:
    """Load the profile, before tests are imported and take their settings from it."""
    for name, share in SHARES.items():
        settings.register_profile(
            name,
            max_examples=round(100 * share),
            deadline=None,
            derandomize=name == "ci",
            print_blob=True,
            suppress_health_check=_TOLERATED,
        )
    settings.load_profile(PROFILE)
