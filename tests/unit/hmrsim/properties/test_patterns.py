"""The 22 patterns: against their published formulas on random words, and one by one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests import ltl
from tests.cases import case
from tests.profiles import examples
from tests.watching import Feed, ward

PLACES = {"l1": [0.0, 0.0], "l2": [10.0, 0.0], "l3": [20.0, 0.0], "elsewhere": [50.0, 0.0]}
words = st.lists(st.sampled_from(["l1", "l2", "l3"]), max_size=9)
orders = st.permutations(["l1", "l2", "l3"]).flatmap(lambda each: st.integers(1, 3).map(lambda count: each[:count]))
letters = st.lists(st.frozensets(st.sampled_from(["p", "q"])), min_size=1, max_size=9)

ENDLESS = 1e6


def world():
    """Return a world with three places far from each other, and a robot elsewhere."""
    return ward(
        waypoints=PLACES, lanes=[], docks={}, doors={}, demand=[], items={}, robots={"eve": {"at": "elsewhere"}}
    )


def travel(said, visits):
    """Return the monitor of a robot that is at another place each second, and elsewhere in between."""
    feed = Feed({"p": {"robot": "eve", **said}}, world=world())
    feed.monitor.begin(0)
    for i, place in enumerate(visits):
        feed.event(i + 1.0, "teleported", entity="eve", at=PLACES[place], yaw=0.0)
        feed.event(i + 1.5, "teleported", entity="eve", at=PLACES["elsewhere"], yaw=0.0)
    return feed.end(len(visits) + 1.0)


def tell(said, word):
    """Return the monitor of a run with an event at an instant for each letter."""
    feed = Feed({"x": said}, world=world())
    feed.monitor.begin(1_000_000_000)
    for i, letter in enumerate(word, 1):
        for name in sorted(letter):
            feed.event(float(i), "run_reported", label=name)
        if not letter:
            feed.event(float(i), "run_reported", label="tick")
    return feed.end(len(word) + 1.0)


P, Q = ({"event": "run_reported", "where": {"label": name}} for name in ("p", "q"))


@pytest.mark.parametrize(
    ("pattern", "formula"),
    [
        ("visit", ltl.visit),
        ("sequenced_visit", ltl.sequenced_visit),
        ("ordered_visit", ltl.ordered_visit),
        ("strict_ordered_visit", ltl.strict_ordered_visit),
        ("fair_visit", ltl.fair_visit),
    ],
)
@given(places=orders, visits=words)
@examples(60)
def test_visits_agree_with_their_published_formulas(pattern, formula, places, visits):
    word = [*(frozenset([place]) for place in visits), frozenset[str]()]

    assert formula(places)(word, 0) == (not travel({pattern: places}, visits).violations)


@pytest.mark.parametrize(
    ("pattern", "formula"),
    [
        ("ordered_patrolling", ltl.ordered_patrol),
        ("strict_ordered_patrolling", ltl.strict_ordered_patrol),
        ("fair_patrolling", ltl.fair_patrol),
    ],
)
@given(places=orders, visits=words)
@examples(60)
def test_orders_of_patrols_agree_with_their_published_formulas(pattern, formula, places, visits):
    word = [*(frozenset([place]) for place in visits), frozenset[str]()]

    assert formula(places)(word, 0) == (not travel({pattern: places, "every": ENDLESS}, visits).violations)


FORMULAS = {
    "past_avoidance": ({"past_avoidance": P, "until": Q}, ltl.until(ltl.not_(ltl.is_("p")), ltl.is_("q"))),
    "global_avoidance": ({"global_avoidance": P}, ltl.always(ltl.not_(ltl.is_("p")))),
    "future_avoidance": (
        {"future_avoidance": P, "after": Q},
        ltl.always(ltl.implies(ltl.is_("q"), ltl.always(ltl.not_(ltl.is_("p"))))),
    ),
    "upper_restricted_avoidance": ({"upper_restricted_avoidance": P, "count": 2}, ltl.not_(ltl.at_least("p", 3))),
    "exact_restricted_avoidance": ({"exact_restricted_avoidance": P, "count": 2}, ltl.exactly("p", 2)),
    "lower_restricted_avoidance": ({"lower_restricted_avoidance": P, "count": 2}, ltl.at_least("p", 2)),
    "delayed_reaction": (
        {"delayed_reaction": P, "then": Q},
        ltl.always(ltl.implies(ltl.is_("p"), ltl.eventually(ltl.is_("q")))),
    ),
    "instantaneous_reaction": (
        {"instantaneous_reaction": P, "then": Q},
        ltl.always(ltl.implies(ltl.is_("p"), ltl.is_("q"))),
    ),
    "bound_reaction": ({"bound_reaction": P, "then": Q}, ltl.always(ltl.same(ltl.is_("p"), ltl.is_("q")))),
}


@pytest.mark.parametrize("pattern", [*FORMULAS])
@given(word=letters)
@examples(60)
def test_other_patterns_agree_with_their_published_formulas(pattern, word):
    said, formula = FORMULAS[pattern]

    assert formula([*word, frozenset()], 0) == (not tell(said, word).violations)


NEXT = {
    "prompt_reaction": ltl.implies(ltl.is_("p"), ltl.next_(ltl.is_("q"))),
    "bound_delay": ltl.same(ltl.is_("p"), ltl.next_(ltl.is_("q"))),
}
"""What G is said of; at the last letter nothing is, as it has no next one."""


@pytest.mark.parametrize("pattern", [*NEXT])
@given(word=letters)
@examples(60)
def test_next_patterns_agree_with_their_published_formulas(pattern, word):
    """The next instant is that of the next of the two events."""
    heard = [frozenset[str](), *(letter for letter in word if letter)]

    holds = all(NEXT[pattern](heard, i) for i in range(len(heard) - 1))

    assert holds == (not tell({pattern: P, "then": Q}, [frozenset(), *word]).violations)


def test_leaving_a_place_early_violates_a_wait():
    said = {"wait": {"robot": "eve", "at": "elsewhere"}, "until": P}
    found = []
    for times in ((5.0, 8.0), (8.0, 5.0)):
        feed = Feed({"x": said}, world=world())
        feed.monitor.begin(0)
        acts = {
            times[0]: ("run_reported", {"label": "p"}),
            times[1]: ("teleported", {"entity": "eve", "at": [0.0, 0.0], "yaw": 0.0}),
        }
        for at in sorted(acts):
            feed.event(at, acts[at][0], **acts[at][1])
        found.append([each[3] for each in feed.end(9).violations])

    assert [[], ["eve is at elsewhere no longer, before run_reported (label p)"]] == found


def test_a_wait_needs_its_stimulus():
    feed = Feed({"x": {"wait": {"robot": "eve", "at": "elsewhere"}, "until": P}}, world=world())
    feed.monitor.begin(0)

    assert ["never: run_reported (label p)"] == [each[3] for each in feed.end(9).violations]


def test_a_late_visit_is_reported_with_the_missing_place():
    late = travel({"sequenced_visit": ["l1", "l2"], "within": 2.5}, ["l1", "l3", "l2"])
    in_time = travel({"sequenced_visit": ["l1", "l2"], "within": 4.0}, ["l1", "l3", "l2"])

    assert ([(2.5, "p", "eve", "l2 not within 2.5 s")], ("holds", 0.25)) == (late.violations, in_time.verdict("p")[1:3])


def test_the_reason_of_a_violated_order_is_the_early_place():
    early = travel({"ordered_visit": ["l1", "l2", "l3"]}, ["l1", "l3", "l2", "l3"])
    again = travel({"strict_ordered_visit": ["l1", "l2"]}, ["l1", "l1", "l2"])

    assert (["l3 too early"], ["l1 again too early"]) == tuple(
        [each[3] for each in feed.violations] for feed in (early, again)
    )


@pytest.mark.parametrize(
    ("pattern", "every", "visits", "violations"),
    [
        ("patrolling", 3.0, ["l1", "l2", "l1", "l2", "l1", "l2"], []),
        ("patrolling", 3.0, ["l1", "l2", "l1", "l1", "l1", "l1"], [(5.5, "l2 not every 3 s")]),
        ("sequenced_patrolling", 3.0, ["l1", "l2", "l1", "l2"], []),
        ("sequenced_patrolling", 3.0, ["l2", "l1", "l1", "l2"], [(3.0, "l2 not every 3 s")]),
        ("ordered_patrolling", 9.0, ["l1", "l2", "l1", "l2"], []),
        ("ordered_patrolling", 9.0, ["l1", "l2", "l2"], [(3.0, "l2 too early")]),
        ("strict_ordered_patrolling", 9.0, ["l1", "l1", "l2"], [(2.0, "l1 again too early")]),
        ("fair_patrolling", 9.0, ["l1", "l2", "l1", "l2"], []),
        ("fair_patrolling", 9.0, ["l1", "l2", "l2"], [(3.0, "l2 again too early")]),
        ("fair_patrolling", 2.5, ["l1", "l3"], [(2.5, "l2 not every 2.5 s")]),
    ],
)
def test_each_place_or_round_of_a_patrol_has_a_time_limit(pattern, every, visits, violations):
    found = travel({pattern: ["l1", "l2"], "every": every}, visits).violations

    assert violations == [(at, reason) for at, _, _, reason in found]


def test_a_patrol_that_is_cut_off_holds_if_a_round_was_in_time():
    """Without a complete round it is undecided."""
    done, begun = (
        travel({"sequenced_patrolling": ["l1", "l2"], "every": 9.0}, each) for each in (["l1", "l2"], ["l1"])
    )

    assert [("holds", 1 - 2 / 9), ("undecided", 0.0)] == [feed.verdict("p")[1:3] for feed in (done, begun)]


def test_a_delayed_reaction_can_have_a_time_limit():
    feed = tell({"delayed_reaction": P, "then": Q, "within": 2}, [{"p"}, {"p"}, set(), set(), {"q"}])

    assert [(3.0, "not within 2 s: run_reported (label q)")] == [(at, why) for at, _, _, why in feed.violations]


def test_an_instantaneous_reaction_can_be_of_the_robot_of_the_stimulus():
    said = {
        "instantaneous_reaction": {"event": "fault_began", "where": {"fault": "slip"}},
        "then": {"robot": "$robot", "is": "stopped"},
    }
    feed = Feed({"x": said})
    feed.event(3.0, "fault_began", fault="slip", name="s", robot="eve").end(9)

    assert [(3.0, "x", "eve", "not at once: $robot is stopped")] == feed.violations


def test_patterns_without_a_stimulus_are_not_exercised():
    for said in (
        {"instantaneous_reaction": P, "then": Q},
        {"delayed_reaction": P, "then": Q},
        {"prompt_reaction": P, "then": Q},
        {"bound_reaction": P, "then": Q},
        {"bound_delay": P, "then": Q},
        {"future_avoidance": Q, "after": P},
    ):
        with case(said):
            assert "never_exercised" == tell(said, [frozenset()]).verdict("x").state


@pytest.mark.parametrize(
    ("said", "word", "ending", "state", "robustness"),
    [
        ({"past_avoidance": P, "until": Q}, [{"q"}, {"p"}], "succeeded", "holds", 1.0),
        ({"past_avoidance": P, "until": Q}, [set()], "stopped", "undecided", 0.0),
        ({"future_avoidance": P, "after": Q}, [{"p"}, {"q"}], "succeeded", "holds", 1.0),
        ({"upper_restricted_avoidance": P, "count": 4}, [{"p"}], "succeeded", "holds", 0.75),
        ({"exact_restricted_avoidance": P, "count": 1}, [{"p"}], "succeeded", "holds", 1.0),
        ({"lower_restricted_avoidance": P, "count": 2}, [{"p"}], "stopped", "undecided", 0.0),
        ({"lower_restricted_avoidance": P, "count": 2}, [{"p"}, {"p"}], "succeeded", "holds", 1.0),
        ({"instantaneous_reaction": P, "then": Q}, [{"p", "q"}], "succeeded", "holds", 1.0),
        ({"prompt_reaction": P, "then": Q}, [{"p"}], "succeeded", "undecided", 0.0),
        ({"prompt_reaction": P, "then": Q}, [{"p"}, {"q"}], "succeeded", "holds", 1.0),
        ({"delayed_reaction": P, "then": Q}, [{"p"}], "stopped", "undecided", 0.0),
        ({"delayed_reaction": P, "then": Q, "within": 4}, [{"p"}, set(), {"q"}], "succeeded", "holds", 0.5),
        ({"delayed_reaction": P, "then": Q, "within": 4}, [{"p"}], "succeeded", "undecided", 0.0),
    ],
)
def test_patterns_hold_with_robustness_or_are_undecided(said, word, ending, state, robustness):
    feed = Feed({"x": said}, world=world())
    feed.monitor.begin(1_000_000_000)
    for i, letter in enumerate(word, 1):
        for name in sorted(letter) or ["tick"]:
            feed.event(float(i), "run_reported", label=name)
    verdict = feed.end(len(word) + 1.0, ending).verdict("x")

    assert ([], state, robustness) == (feed.violations, *verdict[1:3])


def test_a_visit_that_an_end_cuts_off_is_undecided():
    found = []
    for ending, said in (("stopped", {}), ("succeeded", {"within": 99.0})):
        feed = Feed({"p": {"visit": ["l1", "l2"], "robot": "eve", **said}}, world=world())
        feed.event(1.0, "teleported", entity="eve", at=PLACES["l1"], yaw=0.0).end(9.0, ending)
        found.append((feed.violations, feed.verdict("p").state))

    assert [([], "undecided")] * 2 == found
