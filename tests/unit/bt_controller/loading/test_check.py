"""Invalid files: one line for each error, with its place and a remedy."""

from __future__ import annotations

import pytest

from bt_controller.errors import TreeError
from bt_controller.nodes import registry


def _tree(body):
    return f'<BehaviorTree ID="A">{body}</BehaviorTree>'


NODES = [
    ("<Sya/>", "<Sya>: unknown node; did you mean 'Say'?"),
    ("<Hover/>", "<Hover>: unknown node; see bt-controller nodes"),
    ('<Action ID="Sya"/>', "<Sya>: unknown node; did you mean 'Say'?"),
    ("<Action/>", '<Action>: needs ID="…", the name of a node'),
    ('<Control ID="Say"/>', "<Control>: 'Say' is not of this kind; use <Say>"),
    ("<A/>", '<A>: is a tree, not a node; write <SubTree ID="A"/>'),
    ("<Say><Say/></Say>", "<Say>: has 1 child; expected none"),
    ("<Same/>", "<Same>: has no children; expected exactly 1"),
    ('<All name="x"/>', "<All> 'x': has no children; expected at least 1"),
    ("<Two><Say/><Say/><Say/></Two>", "<Two>: has 3 children; expected exactly 2"),
]

PORTS = [
    ('<Say txt="a"/>', "<Say>: unknown port 'txt'; did you mean 'text'?"),
    ('<Go goal="1;2" x=""/>', "<Go>: unknown port 'x'; it has goal, speed, note, code, where"),
    ('<Same x=""><Say/></Same>', "<Same>: unknown port 'x'; it has none"),
    ('<Say ID="x"/>', "<Say>: unknown port 'ID'; it has text"),
    ("<Go/>", "<Go>: port 'goal' is missing; write goal=\"…\""),
    (
        '<Go goal="1;2;3;4"/>',
        "<Go>: port 'goal': '1;2;3;4' is not a pose; expected x;y, x;y;yaw, Nav2's nine fields or the name",
    ),
    ('<Go goal="1;2" speed="fast"/>', "<Go>: port 'speed': 'fast' is not a number"),
    (
        '<Go goal="1;2" code="7"/>',
        "<Go>: port 'code': '7' is a value, but the port is an output; use a key: code=\"{…}\"",
    ),
    (
        '<Say text="{a b}"/>',
        "<Say>: port 'text': '{a b}' is not a key of the blackboard; expected letters, digits, '_' and '-'",
    ),
    ('<Say text="{a.b}"/>', "'{a.b}' is not a key of the blackboard"),
    ('<Say text="{/a}"/>', "'{/a}' is not a key of the blackboard"),
    ('<Say text="{name}"/>', "'{name}' is not a key of the blackboard; the name is reserved"),
    ('<Say text="hi {name}"/>', "'hi {name}' is not a value; braces enclose keys of the blackboard: {key}"),
    ('<Say text="{}"/>', "'{}' is not a value; braces enclose keys"),
    ('<Say text="a__DOT__b"/>', "'a__DOT__b' is not a value; '__const_' and '__DOT__' are reserved by py_trees"),
    ('<Put value="1" to="a b"/>', "port 'to': 'a b' is a value, but the port is an output"),
]

SCRIPTS = [
    ('<Say _skipif="x"/>', "<Say>: unknown attribute '_skipif'; did you mean '_skipIf'?"),
    ('<Say _autoremap="true"/>', "<Say>: unknown attribute '_autoremap'; there are _failureIf"),
    ('<Say _skipIf="x &gt;"/>', "<Say>: _skipIf: script 'x >'"),
    ('<Script code=""/>', "<Script>: code: script ''"),
    ("<Script/>", '<Script>: needs code="…", a script'),
    ('<Say _post="name := 1"/>', "<Say>: _post: 'name' is not a valid name of an entry"),
]

SUBTREES = [
    ("<SubTree/>", '<SubTree>: needs ID="…", that of a <BehaviorTree>'),
    ('<SubTree ID="AA"/>', "<SubTree>: unknown tree 'AA'; did you mean 'A'?"),
    ('<SubTree ID="A"/>', "<SubTree>: a tree can't contain itself: 'A' in 'A'"),
    ('<SubTree ID="A"><Say/></SubTree>', "<SubTree>: has children; move them to its <BehaviorTree>"),
    ('<SubTree ID="A" _autoremap="yes"/>', "<SubTree>: _autoremap: 'yes' is neither true nor false"),
    ('<SubTree ID="A" _atoremap="1"/>', "<SubTree>: unknown attribute '_atoremap'; did you mean '_autoremap'?"),
    ('<SubTree ID="A" x="{"/>', "<SubTree>: port 'x': '{' is not a value"),
    ('<SubTree ID="A" x.y="1"/>', "<SubTree>: port 'x.y': not a valid key"),
]


@pytest.mark.parametrize(("body", "error"), [*NODES, *PORTS, *SCRIPTS, *SUBTREES])
def test_a_wrong_element_is_reported_in_one_line(files, body, error):
    with pytest.raises(TreeError) as caught:
        files.load(f'<root BTCPP_format="4">\n{_tree(body)}\n</root>')

    lines = str(caught.value).splitlines()
    assert [line for line in lines if line.startswith(f"tree.xml:2: {error}") or error in line] == lines[:1]
    assert lines[0].startswith("tree.xml:2: <")


RING = """\
<root main_tree_to_execute="A"><BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>
<BehaviorTree ID="B"><Same><SubTree ID="C"/></Same></BehaviorTree>
<BehaviorTree ID="C"><SubTree ID="B"/></BehaviorTree></root>"""

MODEL = """\
<root><TreeNodesModel><SubTree ID="B"><input_port name="x"/></SubTree></TreeNodesModel>
<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree><BehaviorTree ID="B"><Say/></BehaviorTree></root>"""

DOCUMENTS = [
    ('<?xml version="1.0"?><tree/>', 'tree.xml:1: <tree>: is not a file of trees; expected <root BTCPP_format="4">'),
    ("<root/>", 'tree.xml:1: <root>: has no trees; expected <BehaviorTree ID="…">'),
    (
        f'<root BTCPP_format="3">{_tree("<Say/>")}</root>',
        "tree.xml:1: <root>: has the format '3'; expected BTCPP_format=\"4\"",
    ),
    (
        f'<root main_tree_to_excute="A">{_tree("<Say/>")}</root>',
        "tree.xml:1: <root>: unknown attribute 'main_tree_to_excute'; did you mean 'main_tree_to_execute'?",
    ),
    (
        f'<root main_tree_to_execute="B">{_tree("<Say/>")}</root>',
        "tree.xml:1: <root>: unknown tree 'B'; there are A",
    ),
    (f"<root>{_tree('<Say/>')}<BehaviourTree/></root>", "did you mean 'BehaviorTree'?"),
    ("<root><BehaviorTree><Say/></BehaviorTree></root>", 'tree.xml:1: <BehaviorTree>: has no ID; write ID="…"'),
    (f"<root>{_tree('')}</root>", "tree.xml:1: <BehaviorTree>: 'A' has 0 children; expected exactly 1"),
    (f"<root>{_tree('<Say/><Say/>')}</root>", "tree.xml:1: <BehaviorTree>: 'A' has 2 children; expected exactly 1"),
    (f"<root>\n{_tree('<Say/>')}\n{_tree('<Say/>')}</root>", "tree 'A' is already defined at tree.xml:2"),
    (
        '<root><BehaviorTree ID="A"><Say/></BehaviorTree><BehaviorTree ID="B"><Say/></BehaviorTree></root>',
        "<root>: names no tree to run; give main_tree_to_execute or --tree, one of A, B",
    ),
    (RING, "<SubTree>: a tree can't contain itself: "),
    (MODEL, "tree.xml:2: <SubTree>: port 'x' is missing; write x=\"…\", as its model requires"),
]


@pytest.mark.parametrize(("text", "error"), DOCUMENTS)
def test_a_wrong_file_is_reported_in_one_line(files, text, error):
    with pytest.raises(TreeError) as caught:
        files.load(text)

    assert error in str(caught.value)
    assert "Traceback" not in str(caught.value)


def test_all_errors_are_reported_at_once(files):
    other = '<BehaviorTree ID="B"><All>\n<Two x="">\n<Sya/>\n<Say txt=""/>\n</Two></All></BehaviorTree>'
    with pytest.raises(TreeError) as caught:
        files.load(f'<root main_tree_to_execute="A">\n{_tree("<Say/>")}\n{other}</root>')

    assert [
        "tree.xml:4: <Two>: unknown port 'x'; it has none",
        "tree.xml:5: <Sya>: unknown node; did you mean 'Say'?",
        "tree.xml:6: <Say>: unknown port 'txt'; did you mean 'text'?",
    ] == str(caught.value).splitlines()


def test_there_is_an_end_of_errors(files):
    with pytest.raises(TreeError) as caught:
        files.load(_tree("<All>" + "<Hover/>\n" * 1000 + "</All>"))

    lines = str(caught.value).splitlines()
    assert (51, "stopped after 50 errors") == (len(lines), lines[-1])


def test_a_line_is_never_longer_than_a_few_hundred_characters(files):
    with pytest.raises(TreeError) as caught:
        files.load(_tree(f'<Go goal="1;2" speed="{"9" * 5000}x"/>'))

    assert len(str(caught.value)) < 500


def test_the_tree_to_run_can_be_chosen(files):
    other = '<BehaviorTree ID="B"><Put value="1" to="x"/></BehaviorTree>'
    text = f'<root main_tree_to_execute="A">{_tree("<Say/>")}{other}</root>'

    with files.built(text, tree="B") as root:
        assert root.name == "Put"
    with pytest.raises(TreeError, match="unknown tree 'D'; there are A, B"):
        files.load(text, tree="D")


@pytest.mark.parametrize("form", ["<Say/>", '<Action ID="Say"/>', '<Condition ID="Say"/>', '<Say _description="hm"/>'])
def test_a_format_that_is_not_said_and_the_long_forms_of_nodes_are_read(files, form):
    with files.built(f"<root>{_tree(form)}</root>") as root:
        assert (root.name, root.origin) == ("Say", "tree.xml:1")


class TestSize:
    """Trees that unroll to more nodes than any tree needs."""

    @staticmethod
    def _doubling(levels):
        trees = "".join(
            f'<BehaviorTree ID="T{n}"><All><SubTree ID="T{n + 1}"/><SubTree ID="T{n + 1}"/></All></BehaviorTree>'
            for n in range(levels)
        )
        return f'<root main_tree_to_execute="T0">{trees}<BehaviorTree ID="T{levels}"><Say/></BehaviorTree></root>'

    def test_subtrees_that_double_and_double_are_refused(self, files):
        with pytest.raises(TreeError, match=r"'T\d+' would have more than 10000 nodes, with its subtrees"):
            files.load(self._doubling(49))

    def test_subtrees_that_double_a_few_times_are_built(self, files):
        """2^4 leaves, and what leads there."""
        with files.built(self._doubling(4)) as root:
            assert len(list(root.iterate())) == 16 + 15 + 30

    def test_a_chain_of_subtrees_has_an_end(self, files):
        trees = "".join(
            f'<BehaviorTree ID="T{n}"><Same><SubTree ID="T{n + 1}"/></Same></BehaviorTree>' for n in range(60)
        )
        text = f'<root main_tree_to_execute="T0">{trees}<BehaviorTree ID="T60"><Say/></BehaviorTree></root>'

        with pytest.raises(TreeError, match=r"'T10' would be more than 100 levels deep"):
            files.load(text)

    def test_a_tree_of_the_greatest_depth_can_be_run(self, files):
        trees = "".join(
            f'<BehaviorTree ID="T{n}"><Same><SubTree ID="T{n + 1}"/></Same></BehaviorTree>' for n in range(49)
        )
        text = (
            f'<root main_tree_to_execute="T0">{trees}<BehaviorTree ID="T49"><Same><Say/></Same></BehaviorTree></root>'
        )

        assert files.ticked(text)[1] == {"Say": "nothing"}


LIMITS = [
    ('<RateController hz="0"><AlwaysSuccess/></RateController>', "port 'hz': '0' is not a number greater than 0"),
    ('<Timeout msec="-1"><AlwaysSuccess/></Timeout>', "port 'msec': '-1' is not a whole number from 0 to 4294967295"),
    ('<Delay delay_msec="-1"><AlwaysSuccess/></Delay>', "port 'delay_msec': '-1' is not a whole number from 0"),
    ('<Sleep msec="4294967296"/>', "port 'msec': '4294967296' is not a whole number from 0"),
    ('<Wait wait_duration="inf"/>', "port 'wait_duration': 'inf' is not a finite number"),
    ('<BackUp backup_dist="-inf"/>', "port 'backup_dist': '-inf' is not a finite number"),
    ('<LoopInt queue="1;x" value="{v}"><AlwaysSuccess/></LoopInt>', "port 'queue': 'x' is not a whole number"),
    (
        '<BatteryGuard until="90"><AlwaysSuccess/><AlwaysSuccess/></BatteryGuard>',
        "port 'until': '90' is not a number from 0 to 1",
    ),
    (
        '<Parallel success_count="5"><AlwaysSuccess/></Parallel>',
        "port 'success_count': '5' of 1 child is never reached",
    ),
    (
        '<ParallelAll max_failures="3"><AlwaysSuccess/><AlwaysSuccess/></ParallelAll>',
        "port 'max_failures': '3' of 2 children is never reached",
    ),
]


@pytest.mark.parametrize(("body", "error"), LIMITS)
def test_a_value_beyond_its_limits_is_an_error(files, body, error):
    files.nodes = registry()

    with pytest.raises(TreeError) as caught:
        files.load(_tree(body))
    assert error in str(caught.value)


DOUBTS = [
    ('<ComputePathToPose goal="1;2" planner_id="grid_based"/>', "port 'planner_id': no robot serves 'grid_based'"),
    ('<FollowPath path="1;2" controller_id="DWB"/>', "port 'controller_id': no robot serves 'DWB'"),
    ('<PlannerSelector default_planner="Smac"/>', "port 'default_planner': no robot serves 'Smac'"),
    ('<ControllerSelector default_controller="DWB"/>', "port 'default_controller': no robot serves 'DWB'"),
]


@pytest.mark.parametrize(("body", "doubt"), DOUBTS)
def test_a_planner_that_is_not_served_is_doubted(files, body, doubt):
    files.nodes = registry()
    files.load(_tree(body))

    (line,) = files.doubts
    assert doubt in line


def test_a_tag_in_another_case_is_taken_for_the_node_and_doubted(files):
    """Nav2 ships such a tree, which BehaviorTree.CPP refuses."""
    body = _tree('<say text="a"/>')
    files.load(f'<root BTCPP_format="4">\n{body}\n</root>')

    assert ("tree.xml:2: <say>: read as <Say>; BehaviorTree.CPP is case-sensitive",) == files.doubts


def test_what_robots_serve_is_not_doubted(files):
    files.nodes = registry()
    files.load(
        _tree(
            '<Sequence><PlannerSelector default_planner="GridBased" selected_planner="{p}"/>'
            '<FollowPath path="1;2" controller_id="FollowPath"/><SmootherSelector default_smoother="x"/></Sequence>'
        )
    )

    assert () == files.doubts


def test_a_file_without_a_format_is_doubted(files):
    files.load(f"<root>{_tree('<Say/>')}</root>")

    assert (
        'tree.xml:1: <root>: has no BTCPP_format; "4" is assumed, and BehaviorTree.CPP requires it',
    ) == files.doubts


def test_no_main_tree_hides_no_recursion(files):
    with pytest.raises(TreeError) as caught:
        files.load(RING.replace(' main_tree_to_execute="A"', ""))

    first, second = str(caught.value).splitlines()
    assert "names no tree to run" in first
    assert "a tree can't contain itself: " in second


def test_a_tree_without_an_id_is_one_error(files):
    with pytest.raises(TreeError) as caught:
        files.load('<root main_tree_to_execute="A"><BehaviorTree><Say/></BehaviorTree></root>')

    assert 'tree.xml:1: <BehaviorTree>: has no ID; write ID="…"' == str(caught.value)


def test_an_empty_id_is_that_of_no_tree(files):
    with pytest.raises(TreeError, match="<root>: unknown tree ''; there are A"):
        files.load(_tree("<Say/>"), tree="")


def test_a_long_value_is_shortened(files):
    with pytest.raises(TreeError) as caught:
        files.load(_tree(f'<Go goal="1;2" speed="{"9x" * 1000}"/>'))

    assert f"port 'speed': '{'9x' * 30}…' is not a number" in str(caught.value)
