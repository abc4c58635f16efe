"""A test of a whole mission always gives the same result, however busy the machine is.

Asked in https://github.com/open-rmf/rmf_ros2/issues/77, where tests of missions have been flaky since 2021.
"""

import hashlib

from hmrsim.testing import simulation

TREE = "bt_controller.examples.hospital:mission"


def digest(**options: object) -> str:
    """Return the SHA-256 of the trace of a mission."""
    with simulation("hospital", tree=TREE, **options) as run:
        run.to_the_end()
        run.check_succeeded()
        return hashlib.sha256(run.trace.encode()).hexdigest()


def test_the_mission_is_the_same_each_time() -> None:
    """Three runs of a mission of eight robots give the same trace, byte for byte."""
    assert len({digest() for _ in range(3)}) == 1


def test_another_speed_gives_another_trace() -> None:
    """Robots at another speed give another trace, so the comparison can fail."""
    assert digest() != digest(changes={"robots.*.base.speed": 0.5})
