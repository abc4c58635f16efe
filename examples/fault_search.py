"""Find what breaks a controller, and shrink it to the smallest schedule of faults; no simulator has to run.

The porter looks whether it has picked the box up, and tries again. It does not look what it has in its claw when it
arrives: if the box falls on the way, it says that all is well.
"""

from hmrsim.fault_search.summary import Summary
from hmrsim.testing import check
from hmrsim_zenoh import Client, Commander
from hmrsim_zenoh.errors import GoalFailed, GoalRejectedError

WORLD = {
    "waypoints": {"home": [0, 0], "store": [10, 0], "shelf": [20, 0]},
    "lanes": [["home", "store"], ["store", "shelf"]],
    "items": {"box": {"at": [10, 0.3]}},
    "robots": {"porter": {"at": "home", "components": {"claw": {}}}},
}
PROPERTIES = {"properties": {"honest": {"eventually": {"item": "box", "at": "shelf", "carried": False}}}}


def deliver(client: Client) -> bool:
    """Bring the box to the shelf; try each step three times, half a minute apart."""
    porter = Commander(client, "porter")
    steps = [
        lambda: porter.go_to_pose(10, 0),
        lambda: porter.pickup("box"),
        lambda: porter.go_to_pose(20, 0),
        lambda: porter.place(""),
    ]
    for step in steps:
        for _ in range(3):
            try:
                step()
                break
            except (GoalFailed, GoalRejectedError):
                client.sleep(30)
    return True


@check(
    WORLD,
    PROPERTIES,
    python="examples/fault_search.py:deliver",
    budget="1h",
    runs=60,
    space={"only": ["claw_drops", "slip"]},
)
def test_delivery(summary: Summary) -> None:
    """Whatever goes wrong, the box arrives."""
    print(f"{len(summary.findings)} failure in {summary.tried.runs} runs")
    for finding in summary.findings:
        print(f"{finding.failure.property}: {finding.text}")
        for thing, outcome in zip(finding.schedule, finding.without, strict=True):
            print(f"- {thing.describe()}; without it the run ends as {outcome.ending} at {outcome.at:.0f} s")


if __name__ == "__main__":
    try:
        test_delivery()
    except AssertionError:
        print("so the test fails, with the story of that failure")
