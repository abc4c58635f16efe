"""BehaviorTree.CPP's nodes together: in any tree, and in a file."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.errors import TreeError
from bt_controller.loading.file_tree import load_file
from bt_controller.nodes import registry
from bt_controller.scripting.parser import parse
from bt_controller.scripting.scripted import ScriptConditions
from tests.profiles import examples

_CONTROLS = {
    "Sequence": {},
    "SequenceWithMemory": {},
    "ReactiveSequence": {},
    "Fallback": {},
    "ReactiveFallback": {},
    "Parallel": {"failure_count": "2", "success_count": "1"},
    "ParallelAll": {},
    "IfThenElse": {},
    "WhileDoElse": {},
    "Switch2": {"variable": "{turn}", "case_1": "1", "case_2": "2"},
    "TryCatch": {"catch_on_halt": "true"},
}
_DECORATORS = {
    "Inverter": {},
    "ForceSuccess": {},
    "ForceFailure": {},
    "Repeat": {"num_cycles": "2"},
    "RetryUntilSuccessful": {"num_attempts": "-1"},
    "KeepRunningUntilFailure": {},
    "Delay": {"delay_msec": "1500"},
    "Timeout": {"msec": "1500"},
    "RunOnce": {},
    "SkipUnlessUpdated": {"entry": "{turn}"},
    "WaitValueUpdate": {"entry": "{turn}"},
    "LoopInt": {"queue": "1;2"},
}
_CONDITIONS = {"_skipIf": "turn == 1", "_while": "turn != 3", "_onHalted": "halts := turn", "_post": "ends := turn"}

_LEAVES = st.text("SFR-", min_size=1, max_size=5)
_TREES = st.recursive(
    _LEAVES,
    lambda trees: st.one_of(
        st.tuples(st.sampled_from([*_CONTROLS]), st.lists(trees, min_size=3, max_size=3)),
        st.tuples(st.sampled_from([*_DECORATORS, "conditions"]), st.lists(trees, min_size=1, max_size=1)),
    ),
    max_leaves=12,
)


@examples(150, share_fixtures=True)
@given(plan=_TREES, acts=st.lists(st.sampled_from(["tick", "tick", "tick", "halt"]), min_size=4, max_size=12))
def test_what_has_ended_has_nothing_that_runs(node, tree, told, plan, acts):
    def build(plan):
        if isinstance(plan, str):
            return told(plan)
        tag, parts = plan
        children = [build(part) for part in parts]
        if tag == "conditions":
            return node(ScriptConditions.bind({name: parse(text) for name, text in _CONDITIONS.items()}), *children)
        return node(registry()[tag], *children, **_CONTROLS.get(tag, _DECORATORS.get(tag, {})))

    Blackboard.set("/turn", 0)
    root = tree(build(plan))
    for turn, act in enumerate(acts):
        Blackboard.set("/turn", turn % 4)
        if act == "halt":
            root.halt()
            assert {Status.INVALID} == {each.status for each in root.root.iterate()}
            continue
        root.tick(float(turn))
        running = [each for each in root.root.iterate() if each.status is Status.RUNNING]
        assert all(each.parent is None or each.parent.status is Status.RUNNING for each in running)
        if running:
            assert root.due() > turn


FILE = """
<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <SetBlackboard value="3" output_key="tries"/>
      <Script code="left := tries - 1; log := ''"/>
      <RetryUntilSuccessful num_attempts="5">
        <Sequence>
          <Script code="left -= 1; log = log .. 'x'" _post="@ticked := left"/>
          <ScriptCondition code="left == 0"/>
        </Sequence>
      </RetryUntilSuccessful>
      <AlwaysFailure _skipIf="left == 0"/>
      <Switch2 variable="{left}" case_1="1" case_2="0">
        <AlwaysFailure/>
        <SubTree ID="Inner" n="{tries}"/>
        <AlwaysFailure/>
      </Switch2>
      <Precondition if="seen == 3" else="FAILURE"><Sleep msec="500"/></Precondition>
      <LoopDouble queue="1;2.5" value="{value}"><Script code="sum := value + 1"/></LoopDouble>
      <WasEntryUpdated entry="sum"/>
      <UnsetBlackboard key="{value}"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Inner">
    <Script code="@seen := n; own := 1"/>
  </BehaviorTree>
</root>
"""


@pytest.fixture
def written(tmp_path):
    """Return what writes a file and returns its path."""

    def write(text):
        path = tmp_path / "tree.xml"
        path.write_text(text)
        return str(path)

    return write


def test_a_file_uses_them(written, tree, board):
    file, *_ = load_file(written(FILE), registry(), tree="Main", values={})
    root = tree(file.build())

    assert "RS" == root.ticks(10.0, 10.5)
    values = {key: value for key, value in board.items() if key.count("/") == 1}
    assert {"/tries": "3", "/left": 0, "/log": "xx", "/ticked": 0, "/seen": "3", "/sum": 3.5} == values


def test_what_is_not_here_says_what_to_do(written):
    text = '<root BTCPP_format="4"><BehaviorTree ID="Main"><SequenceStar/></BehaviorTree></root>'

    with pytest.raises(TreeError, match="<SequenceStar>: unsupported node: version 4 has SequenceWithMemory"):
        load_file(written(text), registry(), tree=None, values={})
