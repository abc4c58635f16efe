"""Traces of runs, and their replays."""

from __future__ import annotations

import json

import pytest

from hmrsim.actions import registry
from hmrsim.errors import HmrsimError, TraceError
from hmrsim.interfaces.nav2_msgs import UndockRobot
from hmrsim.interfaces.simulation_interfaces import LoadWorld
from hmrsim.protocol.commands import CallService, CancelGoal, GetResult, Participation, SendGoal, Stop
from hmrsim.protocol.topics import Topic
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trace.replay import replay
from hmrsim.trace.writer import DeferredTrace, Header, Trace
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD, A, B, go, send, simulate

WAIT = send("wait", A, "eve", time={"sec": 4})
PICK = send("pickup", B, target_name="letter")


def traced(*commands, until=None, topics=frozenset(), world=None, close=True):
    run = simulate(world, topics=topics, traced=True)
    run(*commands, until=until)
    if close:
        run.simulator.stop()
        return run.lines()
    run.trace.flush()
    return "".join(run.written).splitlines(keepends=True)


def read(lines, kind):
    return [line for line in map(json.loads, lines) if line["kind"] == kind]


class TestTrace:
    def test_it_begins_with_versions_world_and_seed(self):
        (header,) = read(traced(), "header")

        assert 1 == header["contract"]
        assert "small" == header["world"]["name"]
        assert 64 == len(header["world"]["hash"])
        assert 0 == header["seed"]
        assert SMALL_WORLD["bounds"] == header["world"]["definition"]["bounds"]

    def test_a_command_precedes_its_effects(self):
        lines = [json.loads(line) for line in traced((1.5, WAIT))]

        assert ["header", "command", "status", "status", "status", "command", "end"] == [each["kind"] for each in lines]
        assert {"sec": 1, "nanosec": 500_000_000} == lines[1]["stamp"]
        command = tuple(lines[1][key] for key in ("command", "robot", "goal"))
        assert ("send_goal", "eve", {"time": {"sec": 4}}) == command

    def test_a_status_is_as_on_the_wire(self):
        last = read(traced((0.0, WAIT)), "status")[-1]

        assert last == {
            "kind": "status",
            "stamp": {"sec": 4, "nanosec": 0},
            "robot": "eve",
            "action": "wait",
            "goal_id": A,
            "status": 4,
            "result": {"total_elapsed_time": {"sec": 4}},
        }

    def test_events_of_the_world_are_written(self):
        assert [{"robot": "wall_e", "item": "letter"}] == [
            {key: line[key] for key in ("robot", "item")} for line in read(traced((0.0, PICK)), "picked")
        ]

    def test_a_goal_that_is_rejected_is_written(self):
        (rejected,) = read(traced((0.0, WAIT._replace(robot="zoe"))), "rejected")

        assert ("zoe", "unknown_robot") == (rejected["robot"], rejected["reason"])

    def test_lines_are_canonical(self):
        for number, line in enumerate(traced((0.0, PICK), (1.0, go(5.0, 2.0, B)))):
            assert line == json.dumps(json.loads(line), sort_keys=number > 0, separators=(",", ":")) + "\n"

    def test_the_world_keeps_its_order(self):
        """Ids of waypoints and lanes depend on it."""
        waypoints = {name: [float(number), 0.0] for number, name in enumerate(("c", "a", "b"))}
        run = simulate({"waypoints": waypoints, "lanes": [["c", "a"], ["a", "b"]]})
        header = json.loads(Header.of(run.simulator.world, RunSettings()).line())

        assert ["c", "a", "b"] == list(header["world"]["definition"]["waypoints"])

    def test_numbers_of_events_are_rounded(self):
        lines = traced((0.0, go(5.0, 2.0, B)), (1.0 / 3, CancelGoal("wall_e", "navigate_to_pose")))
        (stopped,) = read(lines, "stopped")

        assert [1.333333333, 2.0] == stopped["at"]

    def test_numbers_of_commands_are_exact(self):
        """A replay has to have the same effects."""
        (command, _) = read(traced((0.0, go(1 / 3, 2.0, B))), "command")

        assert 1 / 3 == command["goal"]["pose"]["pose"]["position"]["x"]

    def test_queries_are_not_written(self):
        ask = GetResult("eve", "wait", A, "x")

        assert traced((0.0, WAIT)) == traced((0.0, WAIT), (0.0, ask))

    def test_a_goal_that_asks_for_its_result_has_the_same_trace(self):
        commands = (0.1, go(9.0, 2.0, B)), (2.3, WAIT), (3.1, go(5.0, 2.0, B)._replace(goal_id="c" * 32))
        telling = tuple((at, command._replace(result_to=command.goal_id)) for at, command in commands)

        assert traced(*commands) == traced(*telling)
        assert replay(traced(*telling)).difference is None

    def test_subscribers_do_not_change_the_trace(self):
        commands = (0.1, go(9.0, 2.0, B)), (2.3, WAIT), (3.1, CancelGoal("eve", "wait"))

        assert traced(*commands) == traced(*commands, topics=frozenset(Topic))

    def test_a_full_disk_is_an_error(self):
        def full(_text):
            raise OSError(28, "No space left on device")

        trace = Trace(Header.of(World(), RunSettings()), full)

        with pytest.raises(HmrsimError, match="the trace can't be written: no space left on device"):
            trace.flush()


class TestReplay:
    def test_the_same_run_is_identical(self):
        lines = traced((0.1, go(9.0, 2.0, B)), (0.1, WAIT), (1.7, CancelGoal("eve", "wait")), (2.0, PICK))
        outcome = replay(lines)

        assert outcome.difference is None
        assert (len(lines), 5, True) == (outcome.lines, outcome.commands, outcome.complete)

    def test_running_goals_are_stopped_at_the_end(self):
        outcome = replay(traced((0.5, WAIT), until=2.25))

        assert (None, 2.25) == (outcome.difference, outcome.sim_time)

    @pytest.mark.parametrize(
        "commands",
        [
            [(0.5, Participation("nurse", "dropped", "it died")), (1.0, WAIT)],
            [(0.5, SendGoal("zoe", "dance", None, A)), (0.5, SendGoal("eve", "wait", WAIT.goal, "xyz"))],
        ],
        ids=["participants", "rejected commands"],
    )
    def test_all_commands_are_replayed(self, commands):
        assert replay(traced(*commands)).difference is None

    @pytest.mark.parametrize("seed", [None, 7])
    def test_goals_without_an_id_have_the_same_after_another_world_was_loaded(self, seed):
        run = simulate(seed=seed, traced=True)
        load = LoadWorld.Request(resource_string=json.dumps({**SMALL_WORLD, "seed": 3}))
        run((0.5, CallService("load_world", load)), (0.5, WAIT._replace(goal_id=None)))
        run.simulator.stop()

        assert replay(run.lines()).difference is None

    def test_the_order_of_goals_at_the_end_is_that_of_robots(self):
        """An earlier request for a result must not change it."""
        ask = GetResult("wall_e", "wait", A, "x")
        both = (0.0, WAIT), (0.0, WAIT._replace(robot="wall_e", goal_id=B))

        assert traced((0.0, ask), *both, until=1.0) == traced(*both, until=1.0)

    def test_cancels_by_time_are_the_same(self):
        early = CancelGoal("eve", "wait", stamp=1_000_000_000)
        lines = traced((0.5, WAIT), (1.5, early), (2.0, WAIT._replace(goal_id=B)), (2.5, early))

        assert replay(lines).difference is None
        assert [5, 4] == [line["status"] for line in read(lines, "status") if line["status"] >= 4]

    def test_the_first_line_that_differs_is_shown(self):
        lines = traced((0.0, WAIT), (1.0, PICK))
        number = next(n for n, line in enumerate(lines) if '"kind":"picked"' in line)
        changed = [*lines]
        changed[number] = lines[number].replace("letter", "parcel")
        difference = replay(changed).difference

        assert number + 1 == difference.line
        assert (changed[number], lines[number]) == (difference.was + "\n", difference.now + "\n")
        assert tuple(line[:-1] for line in lines[number - 3 : number]) == difference.before
        assert tuple(line[:-1] for line in lines[number + 1 : number + 4]) == difference.after

    def test_an_extra_line_is_a_difference(self):
        lines = traced((0.0, WAIT), close=False)

        assert replay([*lines, lines[-1]]).difference.now is None

    def test_a_missing_line_is_a_difference(self):
        lines = traced((0.0, WAIT))
        number = next(n for n, line in enumerate(lines) if '"status":4' in line)
        difference = replay(lines[:number] + lines[number + 1 :]).difference

        assert (number + 1, lines[number]) == (difference.line, difference.now + "\n")

    @pytest.mark.parametrize("sec", [3, 7])
    def test_a_command_at_another_time_is_a_difference(self, sec):
        lines = traced((0.0, WAIT), (5.0, PICK))
        number = next(n for n, line in enumerate(lines) if '"pickup"' in line)
        command = json.loads(lines[number])
        at = {"nanosec": 0, "sec": sec}
        lines[number] = json.dumps({**command, "stamp": at}, sort_keys=True, separators=(",", ":")) + "\n"

        assert replay(lines).difference is not None

    def test_a_trace_of_an_older_version_is_rejected(self):
        """Older versions counted events before a command."""
        lines = traced((0.0, WAIT))
        lines[1] = json.dumps({**json.loads(lines[1]), "after": 0}, sort_keys=True, separators=(",", ":")) + "\n"

        with pytest.raises(TraceError, match="line 2: a trace of an older version"):
            replay(lines)

    def test_a_command_follows_all_events_of_its_instant(self):
        run = simulate(traced=True)
        run((0.0, WAIT), (0.0, WAIT._replace(robot="wall_e", goal_id=B)), until=3.0)
        while run.simulator.now < 4.0:
            run.simulator.process_events(4.0, 1)
        run.simulator.submit(WAIT)
        run.simulator.stop()
        lines = run.lines()

        kinds = [(line["kind"], line.get("status")) for line in map(json.loads, lines[1:]) if line["stamp"]["sec"] == 4]
        assert kinds[:3] == [("status", 4), ("status", 4), ("command", None)]
        assert replay(lines).difference is None

    @pytest.mark.parametrize(
        ("line", "why"),
        [
            ("nonsense", "line 2: Invalid JSON"),
            ('{"kind":"command"}', "line 2: stamp: Field required"),
            ('{"kind":"command","stamp":{},"command":"dance"}', "line 2: no command 'dance'; there are send_goal"),
            ('{"kind":"command","stamp":{},"command":"send_goal"}', "line 2: send_goal: robot: Field required"),
            (
                '{"kind":"command","stamp":{},"command":"send_goal","robot":"e","action":"wait","goal":{"x":1},"goal_id":""}',
                "line 2: send_goal: x: Extra inputs are not permitted",
            ),
        ],
    )
    def test_an_invalid_line_is_rejected(self, line, why):
        with pytest.raises(TraceError, match=why):
            replay([traced()[0], f"{line}\n"])

    @pytest.mark.parametrize(
        ("change", "why"),
        [
            (lambda _header: "", "no header of a trace; expected a file that was written with --trace"),
            (lambda _header: "{}\n", "no header"),
            (lambda _header: '{"kind":"status"}\n', "no header"),
            (lambda header: header.replace('"at":"shelf"', '"at":"nowhere"'), r"world: robots.eve.at: no waypoint"),
            (lambda header: json.dumps({**json.loads(header), "step_size": 2.0**64}) + "\n", "no header of a trace"),
            (lambda header: header.replace('"contract":1', '"contract":99'), "a trace of contract 99; this is"),
        ],
        ids=["nothing", "no kind", "a status", "an invalid world", "an invalid step size", "another version"],
    )
    def test_an_invalid_header_is_rejected(self, change, why):
        with pytest.raises(TraceError, match=f"line 1: {why}"):
            replay([change(traced()[0])])


def test_the_order_of_tables_in_a_file_does_not_matter():
    world = {
        "waypoints": {"w": [0, 0]},
        "docks": {"e": {"at": "w"}, "d": {"at": "w"}},
        "robots": {"z": {"at": "w"}, "a": {"at": "w"}},
    }
    run, goal = simulate(world, traced=True), UndockRobot.Goal()
    run((0.0, SendGoal("z", "undock_robot", goal, "a" * 32)), (0.0, SendGoal("a", "undock_robot", goal, "b" * 32)))

    assert replay(run.lines()).difference is None


GOAL = registry()["navigate_to_pose"].goal.model_validate({"pose": {"pose": {"position": {"x": 5.0, "y": 2.0}}}})


class Receiver:
    """Somebody who waits for an answer."""


def test_deferred_writing_gives_the_same_bytes():
    world, settings, pieces = World.model_validate(SMALL_WORLD), RunSettings(), []
    late, trace = DeferredTrace(world, settings), Trace(Header.of(world, settings), pieces.append)
    simulator = Simulator(world, settings, [late, trace])
    simulator.submit(SendGoal("wall_e", "navigate_to_pose", GOAL, "1" * 32, Receiver()))
    trace.flush()
    middle = "".join(pieces)

    assert middle == late.text
    simulator.submit(GetResult("wall_e", "navigate_to_pose", "1" * 32, Receiver()))
    simulator.run()
    simulator.submit(Stop("it is late"))
    trace.flush()
    assert middle != "".join(pieces) == late.text


def test_it_keeps_no_reply_address():
    """The last reference to some of them tells their senders that no further answer comes."""
    world, ended = World.model_validate(SMALL_WORLD), []

    class Ending(Receiver):
        def __del__(self):
            ended.append(self)

    simulator = Simulator(world, sinks=[DeferredTrace(world, RunSettings())])
    simulator.submit(SendGoal("wall_e", "navigate_to_pose", None, "1" * 32, Ending()))
    simulator.submit(GetResult("wall_e", "navigate_to_pose", "2" * 32, Ending()))

    assert len(ended) == 2
