"""A fleet that shares its tasks, with simulator and bt-controller as processes."""

from __future__ import annotations

import json
import signal

import pytest

DELIVER = "bt_controller.examples.deliveries:deliver"


@pytest.fixture
def deliver(serve, command, tmp_path):
    """Return the function that runs the hospital's fleet: exit code, messages in order, the end, the trace."""

    def run(*arguments):
        trace = tmp_path / "trace.jsonl"
        simulator, endpoint = serve("hospital_fleet", "--clock", "lockstep", "--trace", trace)
        code, out, err = command("bt-controller", "run", DELIVER, "--json", *arguments, endpoint=endpoint)
        simulator.end(signal.SIGTERM)
        if err:
            raise AssertionError(err)
        *trees, end = [json.loads(line) for line in out.splitlines()]
        news = [(tree["sim_time"], node["message"]) for tree in trees for node in tree["nodes"] if _is_office(node)]
        return code, news, end, trace.read_bytes()

    return run


def _is_office(node):
    return node["name"] == "Office" and node["message"]


def test_a_fleet_delivers_everything_the_same_each_time(deliver):
    code, news, end, trace = deliver("--robots", "all")
    again = deliver("--robots", "all")
    told = "; ".join(message for _, message in news)

    assert (0, {"fleet": "SUCCESS"}) == (code, end["robots"])
    assert (92.0, "d_fib can't fetch blood_samples: aborted: d_fib has broken down at (24.17, 10.7714)") in news
    assert told.index("nan_e gets blood_samples") < told.index("nan_e has brought blood_samples to lab")
    assert told.index("gopher has to charge: 16%") < told.index("gopher is charged") < told.index("gopher gets")
    assert (news, trace) == (again[1], again[3])
