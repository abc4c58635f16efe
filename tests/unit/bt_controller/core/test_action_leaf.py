"""The lifecycle of the leaf that serves every action."""

from __future__ import annotations

import pytest
from py_trees.behaviours import Success
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.composites import Sequence

from bt_controller.behaviours.robot_actions import Dock, GoTo
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import PortError
from bt_controller.core.robots import Directory, NotServed
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import Duration, Time
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, NavigateToPose, Wait
from hmrsim.interfaces.std_msgs import Header
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import ClientClosed, SimulatorGone

WAIT = Wait.Goal(time=Duration.from_seconds(3.0))
LONG = Wait.Goal(time=Duration.from_seconds(9.0))


def goals(*each):
    """Return what makes one of these goals after the other."""
    return iter(each).__next__


@pytest.fixture
def leaf(client):
    leaf = ActionLeaf("Wait", "wait", WAIT)
    leaf.setup(client=client, robot="wall_e")
    return leaf


class TestSetup:
    """Action, robot and goal are looked up before the first tick."""

    def test_an_action_of_no_name_is_refused_when_the_tree_is_built(self):
        with pytest.raises(ValueError, match=r"no action 'wiat'; did you mean 'wait'\?"):
            ActionLeaf("Wait", "wiat", WAIT)

    def test_an_unknown_robot_is_an_error_that_names_the_robots(self, client):
        with pytest.raises(NotServed, match="no robot 'marvin'; there are eve, wall_e"):
            ActionLeaf("Wait", "wait", WAIT).setup(client=client, robot="marvin")

    def test_an_action_that_the_robot_lacks_is_an_error(self, client):
        with pytest.raises(
            NotServed, match="has no action 'pickup', which needs the component 'claw'; there are navigate_to_pose"
        ):
            ActionLeaf("Grab", "pickup", Pickup.Goal(target_name="x")).setup(client=client, robot="eve")

    def test_a_goal_in_plain_values_may_name_a_place(self, simulation):
        def to(place):
            return simulation(
                "cafe", tree=lambda: ActionLeaf("Go", "navigate_to_pose", {"pose": place}), robots=["chai"]
            )

        run = to("counter")
        assert run.to_the_end().succeeded
        assert ["counter"] == run.visited("chai")
        with pytest.raises(NotServed, match=r"'Go': goal: pose: no place 'conter'; did you mean 'counter'\?"):
            to("conter").to_the_end()

    @pytest.mark.parametrize("target", [7, (1.0,), None])
    def test_a_target_that_is_none(self, target):
        with pytest.raises(TypeError, match=r"GoTo takes the name of a place, \(x, y\) or \(x, y, yaw\), got "):
            GoTo(target)

    def test_a_dock_that_does_not_exist_is_an_error(self, simulation, tmp_path):
        with pytest.raises(NotServed, match=r"'Dock at chrger_1': no place 'chrger_1'; did you mean 'charger_1'\?"):
            simulation("cafe", tree=lambda: Dock("chrger_1"), robots=["mocha"]).to_the_end()
        tree = tmp_path / "dock.xml"
        tree.write_text(
            '<root BTCPP_format="4"><BehaviorTree ID="a"><DockRobot dock_id="chrger_1"/></BehaviorTree></root>'
        )
        with pytest.raises(PortError, match=r"port 'dock_id': no place 'chrger_1'; did you mean 'charger_1'\?"):
            simulation("cafe", tree=tree, robots=["mocha"]).to_the_end()

    @pytest.mark.parametrize("later", [False, True])
    def test_a_goal_with_other_fields_is_an_error(self, simulation, later):
        """Not a failure, which a Retry would hide."""
        goal = {"time": {"sec": "long"}, "tiem": 3}
        leaf = ActionLeaf("Stay", "wait", (lambda: goal) if later else goal)

        with pytest.raises(HmrsimError) as error:
            simulation("cafe", tree=lambda: leaf, robots=["chai"]).to_the_end()
        assert "'Stay'" in str(error.value)
        assert "time.sec: input should be a valid integer, got 'long'" in str(error.value)
        assert "tiem: extra inputs are not permitted, got 3" in str(error.value)

    def test_a_leaf_may_name_another_robot_than_the_trees(self, client):
        leaf = ActionLeaf("Go", "navigate_to_pose", NavigateToPose.Goal(), robot="eve")
        leaf.setup(client=client, robot="wall_e")
        leaf.tick_once()

        assert client.goals[0].robot == "eve"

    @pytest.mark.parametrize("name", ["wall_e/navigate_to_pose", "navigate_to_pose/wall_e", "/wall_e/navigate_to_pose"])
    def test_a_full_name_or_its_alias_means_the_same_action(self, client, name):
        leaf = ActionLeaf("Go", name, NavigateToPose.Goal())
        leaf.setup(client=client, robot="eve")
        leaf.tick_once()

        assert (client.goals[0].robot, client.goals[0].action.name) == ("wall_e", "navigate_to_pose")

    def test_a_tick_without_setup_is_a_mistake(self):
        with pytest.raises(RuntimeError, match="'Wait' was ticked before it was set up"):
            ActionLeaf("Wait", "wait", WAIT).tick_once()


class TestInitialise:
    """The leaf sends its goal upon initialise."""

    @pytest.mark.parametrize("source", ["next_goal", lambda: WAIT], ids=["blackboard", "function"])
    def test_the_goal_may_come_from(self, client, source):
        leaf = ActionLeaf("Wait", "wait", source)
        leaf.setup(client=client, robot="wall_e")
        Blackboard.set("next_goal", WAIT)
        leaf.tick_once()

        assert client.goals[0].goal == WAIT

    @pytest.mark.parametrize("source", ["next_goal", lambda: None])
    def test_without_a_goal_the_leaf_fails(self, client, source):
        leaf = ActionLeaf("Wait", "wait", source)
        leaf.setup(client=client, robot="wall_e")
        leaf.tick_once()

        assert (leaf.status, leaf.feedback_message) == (Status.FAILURE, "no goal to send")
        assert client.goals == []

    def test_a_goal_that_can_not_be_sent_fails_the_leaf(self, client, leaf):
        client.refuses = ClientClosed("the client is closed")
        leaf.tick_once()

        assert (leaf.status, leaf.feedback_message) == (Status.FAILURE, "the client is closed")


STEPS = {
    "tick": lambda leaf, _: leaf.tick_once(),
    "stop": lambda leaf, _: leaf.stop(Status.INVALID),
    "suspend": lambda leaf, _: leaf.suspend(),
    "repeat": lambda leaf, _: leaf.repeat(),
    "accept": lambda _, goal: goal.accept(),
    "succeed": lambda _, goal: goal.succeed(),
    "abort": lambda _, goal: goal.abort(208, "no route to (5, 5)"),
    "preempt": lambda _, goal: goal.abort(740, f"preempted by goal {'a' * 32}"),
    "reject": lambda _, goal: goal.reject("not_ready", "battery empty"),
    "end_canceled": lambda _, goal: goal.end_canceled(),
    "fail": lambda _, goal: goal.fail(SimulatorGone("the simulator is gone")),
    "expire": lambda _, goal: goal.expire(GoalStatus.SUCCEEDED),
    **{status.name: lambda _, goal, status=status: goal.is_known(status) for status in GoalStatus},
}
"""What the tree does with a leaf, and what becomes of its latest goal; a status is that of an earlier life."""
RUNNING, SUCCESS, FAILURE, INVALID = Status.RUNNING, Status.SUCCESS, Status.FAILURE, Status.INVALID


def play(client, leaf, steps):
    for step in steps.split():
        STEPS[step](leaf, client.goals[-1] if client.goals else None)


class TestUpdate:
    """The leaf follows its goal from tick to tick."""

    @pytest.mark.parametrize(
        ("steps", "status", "message"),
        [
            ("tick tick", RUNNING, "sent goal request"),
            ("tick accept succeed tick", SUCCESS, "successfully completed"),
            ("tick reject tick", FAILURE, "rejected: not_ready: battery empty"),
            ("tick abort tick", FAILURE, "aborted: no route to (5, 5)"),
            ("tick end_canceled tick", FAILURE, "canceled: canceled"),
            ("tick accept fail tick", FAILURE, "the simulator is gone"),
        ],
    )
    def test_the_end_of_the_goal_is_that_of_the_leaf(self, client, leaf, steps, status, message):
        play(client, leaf, steps)

        assert ([WAIT], status, message) == ([goal.goal for goal in client.goals], leaf.status, leaf.feedback_message)

    @pytest.mark.parametrize(("end", "written"), [("succeed", True), ("abort", False)])
    def test_only_success_is_written_on_the_blackboard(self, client, end, written):
        leaf = ActionLeaf("Wait", "wait", WAIT, on_success={"waited": True})
        leaf.setup(client=client, robot="wall_e")
        play(client, leaf, f"tick {end} tick")

        assert written is Blackboard.exists("waited")

    def test_an_aborted_goal_fails_with_moveits_message(self, client):
        leaf = ActionLeaf("Grab", "pickup", Pickup.Goal(target_name="anvil"))
        leaf.setup(client=client, robot="wall_e")
        leaf.tick_once()
        client.goals[0].abort(-4, "'anvil' is too heavy")
        leaf.tick_once()

        assert (leaf.status, leaf.feedback_message) == (Status.FAILURE, "aborted: 'anvil' is too heavy")

    def test_feedback_is_shown_field_by_field(self, client, leaf):
        leaf.tick_once()
        client.goals[0].accept()
        client.goals[0].feed(time_left=Duration.from_seconds(2.5))
        leaf.tick_once()

        assert (leaf.status, leaf.feedback_message) == (Status.RUNNING, "feedback: time_left: 2.5 s")

    def test_what_a_tick_would_show_wakes_the_runner(self, client):
        """Feedback and the end are each worth a tick; the acceptance is not."""
        woken = []
        leaf = ActionLeaf("Wait", "wait", WAIT)
        leaf.setup(client=client, robot="wall_e", wake=lambda: woken.append(len(woken)))
        leaf.tick_once()
        client.goals[0].accept()
        client.goals[0].feed()
        client.goals[0].succeed()

        assert woken == [0, 1]


class TestCancel:
    """The leaf lets go of its goal when it is interrupted, and for a while when it is suspended."""

    @pytest.mark.parametrize(
        ("steps", "canceled", "status"),
        [
            ("tick accept stop", True, INVALID),
            ("tick stop", True, INVALID),
            ("tick succeed tick stop", False, INVALID),
            ("tick suspend", True, RUNNING),
        ],
        ids=["while it runs", "before it is accepted", "when it is done", "suspended"],
    )
    def test_a_goal_that_is_not_done_is_canceled(self, client, leaf, steps, canceled, status):
        play(client, leaf, steps)

        assert (canceled, status) == (client.goals[0].canceled, leaf.status)

    def test_a_canceled_goal_stays_open_until_it_has_ended(self, client, leaf):
        """A session must not be closed on a cancel that is on its way."""
        leaf.tick_once()
        leaf.stop(Status.INVALID)
        leaf.tick_once()
        before = [goal.goal_id for goal in leaf.open_goals]
        client.goals[0].end_canceled()

        assert [goal.goal_id for goal in client.goals] == before
        assert [goal.goal_id for goal in leaf.open_goals] == before[1:]

    @pytest.mark.parametrize(
        ("steps", "sent", "status"),
        [
            ("tick succeed tick tick", 2, RUNNING),
            ("tick suspend end_canceled tick", 2, RUNNING),
            ("tick suspend succeed tick", 1, SUCCESS),
            ("tick suspend end_canceled tick end_canceled tick", 2, FAILURE),
            ("suspend tick end_canceled tick", 1, FAILURE),
            ("tick suspend end_canceled stop tick end_canceled tick", 2, FAILURE),
        ],
        ids=[
            "ended, and ticked again",
            "suspended",
            "succeeded although it was canceled",
            "canceled by another client later",
            "suspended before it ran",
            "interrupted while it was suspended",
        ],
    )
    def test_a_goal_is_sent_again_after_its_end_or_a_suspension(self, client, leaf, steps, sent, status):
        play(client, leaf, steps)

        assert (sent, status) == (len(client.goals), leaf.status)


class TestResume:
    """Going on with what was sent in an earlier life."""

    @pytest.fixture
    def life(self, client):
        """Return the function that sets a tree up that goes on with a mission: its second leaf."""

        def begin(goal=WAIT, action="wait"):
            leaf = ActionLeaf("Second", action, goal)
            Sequence("Root", memory=True, children=[Success("Before"), leaf])
            leaf.setup(client=client, robot="wall_e", resume="me/patrol/wall_e")
            return leaf

        return begin

    @pytest.fixture
    def leaf(self, life):
        return life()

    def test_each_life_has_the_same_ids(self, client, life):
        for leaf in (life(), life()):
            for _ in range(2):
                leaf.tick_once()
                client.goals[-1].succeed()
                leaf.tick_once()

        first, second, *again = [goal.goal_id for goal in client.goals]
        assert (again, first == second) == ([first, second], False)

    def test_another_goal_at_the_same_place_has_another_id(self, client, life):
        for leaf in (life(), life(LONG), life(NavigateToPose.Goal(), "navigate_to_pose")):
            leaf.tick_once()

        assert 3 == len({goal.goal_id for goal in client.goals})

    def test_when_a_goal_was_made_does_not_matter(self, client, life):
        for sec in (1, 2):
            header = Header(stamp=Time(sec=sec))
            life(NavigateToPose.Goal(pose=PoseStamped(header=header)), "navigate_to_pose").tick_once()

        assert client.goals[0].goal_id == client.goals[1].goal_id

    def test_steps_that_take_turns_at_one_place_are_counted_each(self, client, life):
        for leaf in (life(goals(WAIT, LONG, WAIT)), life(goals(WAIT, LONG, WAIT))):
            for _ in range(3):
                leaf.tick_once()
                client.goals[-1].succeed()
                leaf.tick_once()

        ids = [goal.goal_id for goal in client.goals]
        assert (ids[3:], 3) == (ids[:3], len({*ids}))

    @pytest.mark.parametrize("refuses", [SimulatorGone("gone"), None], ids=["not sent", "rejected"])
    def test_a_goal_that_has_not_begun_uses_up_no_id(self, client, leaf, refuses):
        """The simulator has not received or not kept it, so the next life would look for it in vain."""
        client.refuses = refuses
        leaf.tick_once()
        client.refuses = None
        play(client, leaf, "tick reject tick tick")

        assert client.goals[0].goal_id == client.goals[1].goal_id

    @pytest.mark.parametrize(
        ("steps", "sent", "status"),
        [
            ("tick SUCCEEDED succeed tick", 1, SUCCESS),
            ("tick ABORTED abort tick", 1, FAILURE),
            ("tick CANCELING end_canceled tick", 2, RUNNING),
            ("tick CANCELED end_canceled tick", 2, RUNNING),
            ("tick EXECUTING end_canceled tick", 1, FAILURE),
            ("tick accept end_canceled tick", 1, FAILURE),
            ("tick ABORTED preempt tick", 2, RUNNING),
            ("repeat tick SUCCEEDED succeed tick", 2, RUNNING),
            ("repeat tick EXECUTING succeed tick", 1, SUCCESS),
            ("tick SUCCEEDED expire tick", 1, SUCCESS),
        ],
        ids=[
            "its success counts",
            "its failure counts",
            "what its end canceled is sent anew",
            "what its end has canceled is sent anew",
            "a robot that is stopped in this life does not drive on",
            "a goal of this life that another client cancels fails",
            "what was dropped for something else, such as charging, is sent anew",
            "a repeated step does anew what has ended",
            "a repeated step takes over what is under way",
            "a robot does not do a step again for the sake of a result",
        ],
    )
    def test_what_became_of_the_goal_in_an_earlier_life_counts(self, client, leaf, steps, sent, status):
        play(client, leaf, steps)

        assert (sent, status) == (len(client.goals), leaf.status)
        assert sent == len({goal.goal_id for goal in client.goals})

    def test_a_step_whose_result_has_expired_says_so(self, client, leaf):
        play(client, leaf, "tick SUCCEEDED expire tick")

        assert "was done before; its result has expired" == leaf.feedback_message

    def test_what_was_dropped_for_the_next_one_leads_to_that(self, client, life):
        """As when a tree replans: its goals preempt each other."""
        replanning = life(goals(WAIT, LONG))
        replanning.tick_once()
        replanning.initialise()
        leaf = life()
        leaf.tick_once()
        client.goals[2].is_known(GoalStatus.ABORTED)
        client.goals[2].abort(740, f"preempted by goal {client.goals[1].goal_id}")
        leaf.tick_once()

        assert Status.RUNNING is leaf.status
        assert client.goals[1].goal_id == client.goals[3].goal_id

    def test_a_computation_whose_result_has_expired_is_done_again(self, client):
        """It is the result that counts, and nothing moves."""
        leaf = ActionLeaf("Plan", "compute_path_to_pose", ComputePathToPose.Goal())
        info = {"robots": [{"name": "wall_e", "actions": ["compute_path_to_pose"]}]}
        leaf.setup(client=client, robot="wall_e", resume="me/m/wall_e", directory=Directory.from_info(info))
        play(client, leaf, "tick SUCCEEDED expire tick")

        assert (leaf.status, len(client.goals)) == (Status.RUNNING, 2)
