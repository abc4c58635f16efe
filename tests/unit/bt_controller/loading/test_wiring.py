"""Mismatched and missing connections between ports."""

from __future__ import annotations

import pytest

from bt_controller.core.ports import Given
from bt_controller.errors import TreeError
from bt_controller.nodes import registry


def _tree(body, rest=""):
    return f'<root main_tree_to_execute="A"><BehaviorTree ID="A">\n{body}</BehaviorTree>\n{rest}</root>'


SUB = '<BehaviorTree ID="S"><Go goal="{g}" code="{c}"/></BehaviorTree>'


SUB_G = "tree.xml:3: <Go>: nothing writes 'sub/g'; share g=\"{…}\" at its <SubTree>, or give it with --set sub/g=…"
GOAL = "tree.xml:3: <Go>: port 'goal' is geometry_msgs/PoseStamped, but 'x' is int at port 'code' of <Go>, tree.xml:2"
CODE = "tree.xml:4: <Go>: port 'code' is int, but 'x' is geometry_msgs/PoseStamped at port 'where' of <Go>, tree.xml:2"


@pytest.mark.parametrize(
    ("body", "error"),
    [
        ('<All><Go goal="1;2" code="{x}"/>\n<Go goal="{x}"/></All>', GOAL),
        ('<All><Go goal="1;2" where="{x}"/>\n<SubTree ID="S" g="{x}" c="{x}"/></All>', CODE),
        ('<SubTree ID="S" g="1;2" c="{=}" _autoremap="true"/>', None),
        ('<All><Go goal="1;2" code="{x}"/><Go goal="1;2" speed="{x}"/></All>', None),
        ('<All><Go goal="1;2" code="{x}"/><Say text="{x}"/><Put value="{x}" to="y"/><Go goal="{y}"/></All>', None),
        ('<All><Script code="x := 1"/><Go goal="{x}"/></All>', None),
    ],
)
def test_two_kinds_on_one_key_are_reported(files, body, error):
    if error is None:
        files.load(_tree(body, SUB))
        return
    with pytest.raises(TreeError) as caught:
        files.load(_tree(body, SUB))

    assert f"{error}; use another key" == str(caught.value)


@pytest.mark.parametrize(
    ("body", "lines"),
    [
        ('<Go goal="{g}"/>', ["tree.xml:2: <Go>: nothing writes 'g'; give it with --set g=…"]),
        ('<Same><SubTree ID="S" name="sub"/></Same>', [SUB_G]),
        ('<SubTree ID="S" g="{h}"/>', ["tree.xml:3: <Go>: nothing writes 'h'; give it with --set h=…"]),
        ('<SubTree ID="S" g="1;2"/>', []),
        ('<All><Go goal="{g}"/><Go goal="1;2" where="{g}"/></All>', []),
        ('<All><Script code="g := 1"/><Go goal="{g}"/></All>', []),
        ('<Go goal="{g}" where="{g}"/>', ["tree.xml:2: <Go>: nothing writes 'g'; give it with --set g=…"]),
        (
            '<All><Go goal="{g}"/><Say text="{x}"/></All>',
            ["tree.xml:2: <Go>: nothing writes 'g'; give it with --set g=…"],
        ),
    ],
)
def test_an_entry_that_is_never_written_is_reported(files, body, lines):
    files.load(_tree(body, SUB))

    assert lines == list(files.unset)


def test_what_is_given_is_not_missing(files):
    files.load(_tree('<All><Go goal="{g}"/><SubTree ID="S"/></All>', SUB), values={"g": "kitchen", "S/g": "1;2"})

    assert files.unset == ()


def test_a_given_value_has_to_be_what_its_ports_take(files):
    with pytest.raises(TreeError, match=r"^tree\.xml:2: <Go>: port 'speed': 'fast' is not a number$"):
        files.load(_tree('<Go goal="1;2" speed="{v}"/>'), values={"v": "fast"})


def test_a_value_for_a_subtree_has_to_be_what_its_ports_take(files):
    with pytest.raises(TreeError, match=r"^tree\.xml:3: <Go>: port 'goal': '1;2;3;4' is not a pose"):
        files.load(_tree('<SubTree ID="S" g="1;2;3;4"/>', SUB))


@pytest.mark.parametrize(
    ("shared", "doubts"),
    [
        ('gaol="1;2"', ("tree.xml:2: <SubTree>: 'S' uses no 'gaol'; did you mean 'goal'?",)),
        ('goal="1;2"', ()),
        ('goal="1;2" elsewhere="x"', ()),
    ],
)
def test_what_is_shared_with_a_subtree_under_another_name_is_doubted(files, shared, doubts):
    subtree = '<BehaviorTree ID="S"><Go goal="{goal}"/></BehaviorTree>'
    files.load(_tree(f'<SubTree ID="S" {shared}/>', subtree).replace("<root", '<root BTCPP_format="4"'))

    assert doubts == files.doubts


def test_a_switch_needs_no_variable(files):
    files.nodes = registry()
    files.load(_tree('<Switch2 variable="{nov}" case_1="a" case_2="b">' + "<AlwaysSuccess/>" * 3 + "</Switch2>"))

    assert files.unset == ()


def test_a_wrong_given_value_is_reported_as_it_was_given(files):
    """A place is known to the simulator only; until then any name will do."""
    with pytest.raises(TreeError, match=r"port 'goal': --set x=1;2;3;4: '1;2;3;4' is not a pose; "):
        files.load(_tree('<Go goal="{x}"/>'), values={"x": Given("1;2;3;4", "x")})


@pytest.mark.parametrize(
    ("values", "doubts"),
    [
        ({"h": "1;2"}, ()),
        ({"S/g": "1;2"}, ("nothing reads 'S/g'",)),
        ({"speeed": "1"}, ("nothing reads 'speeed'; did you mean 'speed'?",)),
        ({"n": "1"}, ()),
        ({"c": "1"}, ("nothing reads 'c'",)),
    ],
)
def test_what_is_given_and_not_read_is_doubted(files, values, doubts):
    body = '<All><SubTree ID="S" g="{h}" c="{c}"/><Go goal="1;2" speed="{speed}"/><Script code="n += 1"/></All>'
    files.load(_tree(body, SUB).replace("<root", '<root BTCPP_format="4"'), values=values)

    assert doubts == files.doubts


@pytest.mark.parametrize(
    ("key", "doubts"),
    [
        ("serverd", ("tree.xml:2: <Go>: port 'speed': nothing writes 'serverd'; did you mean 'served'?",)),
        ("served", ()),
        ("elsewhere", ()),
    ],
)
def test_a_key_that_nothing_writes_and_that_is_like_one_is_doubted(files, key, doubts):
    """The port has a default, so that the tree would run with that."""
    body = f'<All><Script code="served := 2"/><Go goal="1;2" speed="{{{key}}}"/></All>'
    files.load(_tree(body).replace("<root", '<root BTCPP_format="4"'))

    assert doubts == files.doubts


@pytest.mark.parametrize(
    ("script", "doubts"),
    [
        ("a := b", ("tree.xml:2: <Script>: nothing writes 'b', which a script reads",)),
        ("a := 1; b := a", ()),
        ("a := given", ()),
    ],
)
def test_a_script_that_reads_what_nothing_writes_is_doubted(files, script, doubts):
    body = _tree(f'<Script code="{script}"/>').replace("<root", '<root BTCPP_format="4"')
    files.load(body, values={"given": "1"} if "given" in script else {})

    assert doubts == files.doubts
