"""A behavior tree in its process drives a robot through four stages."""

from __future__ import annotations

import re

import pytest


@pytest.fixture
def start_tree(start):
    """Return the function that starts the controller and waits until its goal is sent."""

    def run(endpoint):
        tree = ("bt_controller.examples:go_to_pose", "--robot", "wall_e")
        controller = start("bt-controller", "run", *tree, env={"HMRSIM_CONNECT": endpoint})
        controller.line_with("sent goal request")
        return controller

    return run


def test_the_tree_goes_through_its_four_stages(serve, command):
    _, endpoint = serve("scenario2", "--real-time-factor", "2")
    code, out, err = command(
        "bt-controller", "run", "bt_controller.examples:go_to_pose", "--robot", "wall_e", endpoint=endpoint
    )

    assert 0 == code, err
    sent = (
        r"GoToPoseSequence \[\*\]\n.*GoToPoseFallback \[\*\]\n"
        r".*CheckArrived \[✕\] -- 'arrived' comparison failed \[v: Status.RUNNING\]\[e: Status.SUCCESS\]\n"
        r".*GoToPoseAction \[\*\] -- sent goal request"
    )
    under_way = r"GoToPoseAction \[\*\] -- feedback: remaining: \d+\.\d+"
    arrived = r"GoToPoseSequence \[✓\]\n.*GoToPoseFallback \[✓\]\n.*\n.*GoToPoseAction \[✓\] -- successfully completed"
    confirmed = r"CheckArrived \[✓\] -- 'arrived' comparison succeeded \[v: Status.SUCCESS\]\[e: Status.SUCCESS\]"
    at = 0
    for stage in (sent, under_way, arrived, confirmed):
        found = re.compile(stage).search(out, at)
        assert found, (stage, out)
        at = found.end()
    remaining = [float(number) for number in re.findall(r"remaining: ([\d.]+)", out)]
    assert sorted(set(remaining), reverse=True) == list(dict.fromkeys(remaining))


def test_a_controller_exits_with_1_when_its_simulator_dies(serve, start_tree):
    simulator, endpoint = serve("scenario2", "--real-time-factor", "0.05")
    controller = start_tree(endpoint)
    simulator.process.kill()
    code, out, err = controller.end()

    assert 1 == code
    assert "simulator" in out + err
    assert "Traceback" not in err
