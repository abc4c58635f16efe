"""Limits of runs."""

from __future__ import annotations

import pytest

from hmrsim.experiments.file.model import Limits
from hmrsim.trials.guards import ending_of_lost


@pytest.mark.parametrize(("seconds", "ending"), [(0.1, "died"), (34.9, "died"), (35.0, "hung")])
def test_a_run_whose_process_is_gone_hung_if_the_guard_was_due_to_end_it(seconds, ending):
    """A worker that dies under load, after the limit but before the guard ends it, was not ended for hanging."""
    assert ending == ending_of_lost(Limits(wall=20.0, processor=60.0), seconds)[0]
