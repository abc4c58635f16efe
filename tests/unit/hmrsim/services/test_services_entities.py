"""Services that list entities and their states."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.interfaces.simulation_interfaces import Result, SimulatorFeatures
from hmrsim.services import registry
from hmrsim.services._entities import PatternError, compiled
from tests.simulation import B, go, send

EVERYBODY = ["wall_e", "eve", "cart", "parcel", "anvil", "letter"]


class TestFilters:
    @pytest.mark.parametrize(
        ("filters", "expected"),
        [
            ({}, EVERYBODY),
            ({"filter": "^.{3,4}$"}, ["eve", "cart"]),
            ({"filter": "e"}, ["wall_e", "eve", "parcel", "letter"]),
            ({"categories": [{"category": 1}]}, ["wall_e", "eve", "cart"]),
            ({"categories": [{"category": 4}]}, ["parcel", "anvil", "letter"]),
            ({"categories": [{"category": 2}, {"category": 4}]}, ["parcel", "anvil", "letter"]),
            ({"tags": {"tags": ["claw"]}}, ["wall_e", "eve"]),
            ({"tags": {"tags": ["carrier", "item"]}}, ["cart", "parcel", "anvil", "letter"]),
            ({"tags": {"tags": ["robot", "claw"], "filter_mode": 1}}, ["wall_e", "eve"]),
            ({"tags": {"tags": ["robot", "item"], "filter_mode": 1}}, []),
            ({"bounds": {"type": 3, "points": [{"x": 1.0, "y": 2.0}, {"x": 0.5}]}}, ["wall_e", "letter"]),
            ({"bounds": {"type": 1, "points": [{"x": 9.5, "y": 2.1}, {"x": 4.0, "y": 0.0}]}}, ["eve", "cart", "anvil"]),
            ({"filter": "a", "tags": {"tags": ["item"]}}, ["parcel", "anvil"]),
        ],
    )
    def test_entities_must_pass_all_filters(self, run, filters, expected):
        assert expected == run.ask("get_entities", {"filters": filters}).entities
        assert expected == run.ask("get_entities_states", {"filters": filters}).entities

    @pytest.mark.parametrize(
        ("filters", "code", "why"),
        [
            ({"filter": "("}, 4, "filter '(': missing ): ("),
            ({"filter": "x" * 300}, 4, "it has 300 characters; at most 256 are allowed"),
            ({"bounds": {"type": 2}}, 0, "bounds of type 2 are not supported; use a box or a sphere"),
            ({"bounds": {"type": 3}}, 4, "a box or a sphere has 2 points, got 0"),
        ],
    )
    def test_an_invalid_filter_is_rejected(self, run, filters, code, why):
        answer = run.ask("get_entities", {"filters": filters})

        assert (code, []) == (answer.result.result, answer.entities)
        assert why in answer.result.error_message


class TestStates:
    def test_a_driving_robot_has_a_velocity(self, run):
        run((0.0, go(9, 2)), until=1.5)
        state = run.ask("get_entity_state", {"entity": "wall_e"}).state

        stamp, linear = state.header.stamp, state.twist.linear
        assert ("map", 1, 500_000_000) == (state.header.frame_id, stamp.sec, stamp.nanosec)
        assert (2.5, 2.0) == (state.pose.position.x, state.pose.position.y)
        assert (1.0, 0.0) == (linear.x, linear.y)

    def test_an_item_moves_with_the_robot_that_holds_it(self, run):
        run((0.0, send("pickup", target_name="letter")), (0.0, go(9, 2, B)), until=1.5)
        state = run.ask("get_entity_state", {"entity": "letter"}).state

        assert (2.5, 1.0) == (state.pose.position.x, state.twist.linear.x)

    def test_an_item_on_the_ground_stands(self, run):
        state = run.ask("get_entity_state", {"entity": "parcel"}).state

        assert (9.0, 2.3, 0.0) == (state.pose.position.x, state.pose.position.y, state.twist.linear.x)

    def test_the_info_of_an_entity_has_category_and_tags(self, run):
        robot = run.ask("get_entity_info", {"entity": "wall_e"}).info
        item = run.ask("get_entity_info", {"entity": "parcel"}).info

        tags = ["robot", "nurse", "claw"]
        assert (1, "nurse with claw", tags) == (robot.category.category, robot.description, robot.tags)
        assert (4, "item of 0.2 kg", ["item"]) == (item.category.category, item.description, item.tags)

    @pytest.mark.parametrize("service", ["get_entity_info", "get_entity_state", "delete_entity", "set_entity_state"])
    def test_an_unknown_entity_lists_the_existing_ones(self, run, service):
        result = run.ask(service, {"entity": "hal"}).result

        assert Result.RESULT_NOT_FOUND == result.result
        assert "no entity 'hal'; there are: anvil, cart, eve, letter, parcel, wall_e" == result.error_message

    def test_the_most_similar_entity_is_suggested(self, run):
        result = run.ask("get_entity_state", {"entity": "walle"}).result

        assert "no entity 'walle'; did you mean 'wall_e'?" == result.error_message


class TestNamedPoses:
    @pytest.fixture
    def run(self, make_run):
        return make_run(
            {
                "waypoints": {"home": [1, 2], "door": [5, 2]},
                "places": {"pharmacy": {"at": [9, 2.4]}, "door": {"at": [5, 2]}},
                "docks": {"charger": {"at": [1, 1], "type": "charger"}},
            }
        )

    def test_all_named_poses_are_listed(self, run):
        poses = run.ask("get_named_poses").poses

        assert [
            ("pharmacy", ["place"], 9.0, 2.4),
            ("door", ["place", "waypoint"], 5.0, 2.0),
            ("charger", ["dock", "charger"], 1.0, 1.0),
            ("home", ["waypoint"], 1.0, 2.0),
        ] == [(pose.name, pose.tags, pose.pose.position.x, pose.pose.position.y) for pose in poses]

    def test_named_poses_are_filtered_by_tag(self, run):
        poses = run.ask("get_named_poses", {"tags": {"tags": ["waypoint"]}}).poses

        assert ["door", "home"] == [pose.name for pose in poses]

    def test_named_poses_have_no_bounds(self, run):
        known = run.ask("get_named_pose_bounds", {"name": "home"})
        unknown = run.ask("get_named_pose_bounds", {"name": "moon"})

        assert (1, 0) == (known.result.result, known.bounds.type)
        assert 2 == unknown.result.result
        assert "no pose 'moon'; there are: pharmacy, door, charger, home" == unknown.result.error_message


def test_features_are_those_of_the_services(run):
    features = run.ask("get_simulator_features").features.features

    assert sorted({feature for service in registry().values() for feature in service.features}) == features
    assert {SimulatorFeatures.SPAWNING, SimulatorFeatures.STEP_SIMULATION_ACTION} <= {*features}
    assert SimulatorFeatures.WORLD_UNLOADING not in features


class TestPattern:
    @pytest.mark.parametrize(
        ("pattern", "matching", "others"),
        [
            ("", ["", "any"], []),
            ("a", ["a", "cab"], ["", "b"]),
            ("^ab$", ["ab"], ["cab", "abc"]),
            ("^(wall|burn)_e$", ["wall_e", "burn_e"], ["eve"]),
            ("^a*b+c?$", ["b", "aabb", "abc"], ["a", "acc"]),
            ("^x{2}$", ["xx"], ["x", "xxx"]),
            ("^x{2,}$", ["xx", "xxxxx"], ["x"]),
            ("^x{1,2}$", ["x", "xx"], ["", "xxx"]),
            ("^[a-c]$", ["b"], ["d", "-"]),
            ("^[^a-c]$", ["d"], ["b", ""]),
            ("^[]a-]+$", ["]", "a-"], ["b"]),
            ("^robot_[[:digit:]]+$", ["robot_12"], ["robot_", "robot_x"]),
            (r"^\.$", ["."], ["x"]),
            ("^.$", ["x", "."], ["", "xx"]),
            ("^(a|)$", ["a", ""], ["b"]),
            ("a|^b", ["xa", "b"], ["xb"]),
        ],
    )
    def test_patterns_match_as_in_posix(self, pattern, matching, others):
        search = compiled(pattern)

        assert matching == [text for text in matching if search(text)]
        assert [] == [text for text in others if search(text)]

    @pytest.mark.parametrize(
        ("pattern", "why"),
        [
            ("(a", "missing )"),
            ("a)", "unexpected )"),
            ("*a", "no argument for repetition operator: *"),
            ("a{3,2}", "invalid repetition size: {3,2}"),
            ("a{1001}", "invalid repetition size"),
            ("[a", "missing ]"),
            ("[b-a]", "invalid character class range: b-a"),
            ("[[:nope:]]", "invalid character class range: [:nope:]"),
            ("\\", "trailing \\"),
            ("\\d", "invalid escape sequence"),
            ("(a)\\1", "invalid escape sequence"),
            ("(x{900})" * 30, "pattern too large"),
            ("\ud800", "unpaired surrogate"),
        ],
    )
    def test_invalid_patterns_are_rejected(self, pattern, why):
        with pytest.raises(PatternError, match=re.escape(why)):
            compiled(pattern)

    @pytest.mark.parametrize("pattern", ["(a+)+$", "(a|a)*b", "(a*)*b", "((((a*)*)*)*)*b", "((a{0,30}){30})b"])
    def test_hostile_patterns_are_matched(self, pattern):
        """Python's engine would take years for such a pattern."""
        assert not compiled(pattern)("a" * 100 + "c")

    def test_huge_repetitions_are_rejected(self):
        with pytest.raises(PatternError, match="invalid repetition size"):
            compiled("(((a{0,255}){255}){255})b")

    @given(
        st.text("ab", max_size=6),
        st.recursive(
            st.sampled_from(["a", "b", ".", "[ab]", "[^a]"]),
            lambda parts: st.one_of(
                st.tuples(parts, parts).map("".join),
                st.tuples(parts, parts).map("({0[0]}|{0[1]})".format),
                st.tuples(parts, st.sampled_from(["*", "+", "?", "{2}", "{1,2}"])).map("({0[0]}){0[1]}".format),
            ),
            max_leaves=6,
        ),
    )
    def test_patterns_match_as_in_python(self, text, pattern):
        assert bool(re.search(f"^({pattern})$", text)) == compiled(f"^({pattern})$")(text)


def test_a_robot_that_turns_has_an_angular_velocity(make_run):
    run = make_run({"robots": {"spinner": {"at": [0, 0], "base": {"turning_rate": 0.5}}}})
    run((0.0, go(0, 5, robot="spinner")), until=1.0)
    twist = run.ask("get_entity_state", {"entity": "spinner"}).state.twist

    assert (0.5, 0.0) == (pytest.approx(twist.angular.z), math.hypot(twist.linear.x, twist.linear.y))
