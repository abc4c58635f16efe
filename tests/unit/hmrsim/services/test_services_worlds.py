"""Loading another world while the simulation runs."""

from __future__ import annotations

import json

import pytest
from pydantic import ValidationError

from hmrsim.diagnostics import shown
from hmrsim.documents import yaml_text
from hmrsim.protocol.commands import GetResult
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import RosterChanged
from hmrsim.settings.run import RunSettings
from hmrsim.world_checks import load_world, world_hash
from tests.simulation import go, simulate

GOAL = "a" * 32
OTHER = """
name: other
waypoints: {a: [0, 0], b: [4, 0]}
lanes: [[a, b]]
robots: {wall_e: {at: a}, zoe: {at: b, script: [Go a]}}
seed: 3
"""


def load(run, **request):
    return run.ask("load_world", request)


def play(run):
    run.ask("set_simulation_state", {"state": {"state": 1}})


def test_everything_is_replaced(run):
    run.simulator.advance(3.0)
    answer = load(run, resource_string=OTHER)

    assert (1, "other") == (answer.result.result, answer.world.name)
    assert ["wall_e", "zoe"] == run.ask("get_entities").entities
    assert ["a", "b"] == [pose.name for pose in run.ask("get_named_poses").poses]
    assert (3, 0.0) == (run.simulator.seed, run.simulator.now)


def test_a_world_that_an_overlay_makes_too_large_is_rejected(run, monkeypatch):
    monkeypatch.setattr(yaml_text, "MAX_NODES", 1_000)
    grown = "overlay: {each 1..400: {places.p$i: {at: [0, 0]}}}\n"

    answer = load(run, resource_string=OTHER + grown)

    assert 103 == answer.result.result
    assert "the world that comes of it has more than 1000 values, aliases written out" == answer.result.error_message
    assert ["a", "b"] != [pose.name for pose in run.ask("get_named_poses").poses]


def test_a_loaded_world_is_stopped(run):
    load(run, resource_string=OTHER)
    run.simulator.advance(9.0)
    before = run.simulator.now, run.ask("get_simulation_state").state.state
    play(run)
    run.simulator.run()

    assert (0.0, 0) == before
    assert ((0.0, 0.0), 4.0) == (run.simulator.robots["zoe"].pose().point, run.simulator.scripts.all["zoe"].ended)


def test_goals_are_aborted_first(run):
    run((0.0, go(9.0, 2.0)), (0.0, GetResult("wall_e", "navigate_to_pose", GOAL, "result")), until=1.5)
    load(run, resource_string=OTHER)

    assert (1.5, "ABORTED") == run.log.changes(GOAL)[-1]
    assert GoalStatus.ABORTED == run.log.answer("result").status
    assert "another world was loaded" == run.log.answer("result").result.error_msg


def test_robots_drive_in_the_new_world(run):
    load(run, resource_string=OTHER)
    play(run)
    log = run((0.0, go(4.0, 0.0)))

    assert (4.0, "SUCCEEDED") == log.changes(GOAL)[-1]


def test_scripts_of_the_old_world_are_over():
    run = simulate({"waypoints": {"a": [0, 0]}, "robots": {"old": {"at": "a", "script": ["Wait 2", "Wait 3"]}}})
    run.simulator.advance(1.0)
    load(run, resource_string=OTHER)
    play(run)
    run.simulator.run()

    assert ["zoe"] == [*run.simulator.scripts.all]
    assert (4.0, []) == (run.simulator.now, run.log.happened("script_ended")[1:])


def test_subscribers_learn_of_a_loaded_world(run):
    load(run, resource_string=OTHER)

    assert [RosterChanged()] == [event for _, event in run.log.events if isinstance(event, RosterChanged)]
    assert ([(0.0, {"name": "other"})], 1) == (run.log.happened("world_loaded"), run.simulator.generation)


def test_a_given_seed_stays(make_run):
    run = make_run(seed=7)
    load(run, resource_string=OTHER)

    assert 7 == run.simulator.seed


def test_a_shipped_world_is_loaded_by_name(run):
    answer = load(run, uri="scenario1")

    assert (1, "scenario 1") == (answer.result.result, answer.world.name)


@pytest.fixture
def folder(tmp_path):
    """A folder with worlds, beside a file that clients must not read."""
    inside = tmp_path / "worlds"
    (inside / "deep").mkdir(parents=True)
    (inside / "other.yaml").write_text(OTHER)
    (inside / "deep" / "other.yaml").write_text(OTHER)
    (inside / "wrong.yaml").write_text("include: [../secret.yaml]\n")
    (tmp_path / "secret.yaml").write_text("password: 1234\n")
    (inside / "link.yaml").symlink_to(tmp_path / "secret.yaml")
    (inside / "away").symlink_to(tmp_path)
    (inside / "round").symlink_to("round")
    return inside


@pytest.mark.parametrize("uri", ["other.yaml", "deep/../deep/other.yaml", "{}/other.yaml", "file://{}/other.yaml"])
def test_a_file_of_the_allowed_folder_is_loaded(make_run, folder, uri):
    answer = load(make_run(allow_files=folder), uri=uri.format(folder))

    assert (1, "other") == (answer.result.result, answer.world.name), answer.result.error_message


OUTSIDE = ["../secret.yaml", "../none.yaml", "{}/../secret.yaml", "/etc/passwd", "/etc/none", "link.yaml", "round", "."]
OUTSIDE += ["away/secret.yaml", "away/none.yaml", "file:///etc/passwd", "file:///etc/none", "\0"]


@pytest.mark.parametrize("uri", [*OUTSIDE, "{}/other.yaml", "other.yaml"])
def test_without_an_allowed_folder_no_file_is_read(run, folder, uri):
    """The answer must not reveal whether a file exists."""
    uri = uri.format(folder)
    result = load(run, uri=uri).result

    assert 2 == result.result
    assert f"no shipped world {shown(uri)}" in result.error_message
    assert result.error_message.endswith("only of a simulator that was started with --allow-files DIR")


@pytest.mark.parametrize("uri", OUTSIDE)
def test_no_file_outside_the_folder_is_read(make_run, folder, uri):
    """The answer must not reveal whether a file exists, not even by a link."""
    uri = uri.format(folder)
    result = load(make_run(allow_files=folder), uri=uri).result

    assert 2 == result.result
    assert f"{shown(uri)} is neither a shipped world" in result.error_message
    assert "1234" not in result.error_message


def test_no_file_of_the_folder_includes_one_outside(make_run, folder):
    result = load(make_run(allow_files=folder), uri="wrong.yaml").result

    assert 103 == result.result
    assert result.error_message.startswith(
        "wrong.yaml:1: include.0: '../secret.yaml' is outside the folder of this file"
    )


def test_a_missing_folder_is_an_error(tmp_path):
    with pytest.raises(ValidationError, match="none' is not a folder"):
        RunSettings(allow_files=tmp_path / "none")


def test_the_current_world_can_be_loaded_again(run):
    load(run, uri="hospital")
    text = run.ask("get_current_world").world.world_resource.resource_string
    load(run, resource_string=OTHER)
    load(run, resource_string=text)

    assert load_world("hospital").hash == world_hash(run.simulator.world)


@pytest.mark.parametrize(
    ("request_", "code", "why"),
    [
        ({}, 102, "neither uri nor resource_string is given"),
        ({"uri": "hospitl"}, 2, "no shipped world 'hospitl'; did you mean 'hospital'"),
        ({"uri": "/no/such/world.yaml"}, 2, "no shipped world '/no/such/world.yaml'"),
        ({"resource_string": "robots: ["}, 103, "resource_string:"),
        ({"resource_string": "just text"}, 103, "resource_string:1: expected a mapping"),
        ({"resource_string": "include: [/etc/passwd]"}, 103, "include: a text can't include files"),
        ({"resource_string": "{name: a, name: b}"}, 103, "name"),
    ],
)
def test_an_invalid_world_changes_nothing(run, request_, code, why):
    run((0.0, go(9.0, 2.0)), until=1.5)
    answer = load(run, **request_)

    assert code == answer.result.result, answer.result.error_message
    assert why in answer.result.error_message
    assert "small" == run.simulator.world.name
    assert 1.5 == run.simulator.now
    assert "EXECUTING" == run.log.changes(GOAL)[-1][1]


def test_all_errors_are_reported(run):
    text = "robots: {a: {at: nowhere}, b: {type: ghost, at: [1, 2]}}"
    result = load(run, resource_string=text).result

    assert [
        "resource_string: robots.a.at: no waypoint, place or dock 'nowhere'; there are none",
        "resource_string: robots.b.type: no robot type 'ghost'; there are carrier, fetcher",
    ] == result.error_message.splitlines()


class TestAvailable:
    def test_shipped_worlds_are_available(self, run):
        worlds = run.ask("get_available_worlds").worlds

        names = [world.world_resource.uri for world in worlds]
        assert ["cafe", "hospital", "hospital_fleet", "hospital_logistics", "scenario1", "scenario2"] == names[:6]
        assert "zoo/lift" in names[5:]

    @pytest.mark.parametrize(
        ("request_", "code", "number"),
        [
            ({"additional_sources": ["https://example.org"]}, 2, 0),
            ({"additional_sources": ["https://example.org"], "continue_on_error": True}, 1, 15),
            ({"filter": {"tags": ["indoor"]}}, 0, 0),
        ],
    )
    def test_other_sources_are_not_supported(self, run, request_, code, number):
        answer = run.ask("get_available_worlds", request_)

        assert (code, number) == (answer.result.result, len(answer.worlds))


def test_a_world_can_be_json(run):
    assert 1 == load(run, resource_string=json.dumps({"name": "plain", "robots": {"a": {"at": [1, 2]}}})).result.result


def test_a_world_of_too_many_pairs_is_rejected(run):
    """Its checks would make other clients wait."""
    docks = {f"d{i}": {"at": "a"} for i in range(2_100)}
    robots = {f"r{i}": {"at": [i, 1]} for i in range(2_100)}
    text = json.dumps({"name": "big", "waypoints": {"a": [0, 0]}, "docks": docks, "robots": robots})

    answer = load(run, resource_string=text)

    assert answer.result.result == 103
    assert "is too large to be sent by a client: 4,410,000 pairs" in answer.result.error_message
    assert run.simulator.world.name != "big"
