"""The trees that are built from files: names and origins of nodes, and keys as in BehaviorTree.CPP."""

from __future__ import annotations

from unittest.mock import Mock

import pytest
from py_trees.common import Status

from bt_controller.core.blackboards import Board
from bt_controller.errors import TreeError
from bt_controller.loading import file_tree
from bt_controller.nodes import registry
from bt_controller.running.snapshot import nodes_of


def _main(body, *others, **attributes):
    said = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return (
        f'<root main_tree_to_execute="Main"{said}><BehaviorTree ID="Main">{body}</BehaviorTree>{"".join(others)}</root>'
    )


def _tree(tree_id, body):
    return f'<BehaviorTree ID="{tree_id}">{body}</BehaviorTree>'


class TestNodes:
    """The nodes have the names, kinds and origins of the file."""

    TEXT = _main(
        '\n<All name="first">\n<Say/><Say name="hi/there. you"/>\n'
        '<SubTree ID="S"/><SubTree ID="S" name="again"/></All>',
        _tree("S", '\n<Same name="hi"><Say _skipIf="x" _post="y := 1"/></Same>'),
    )

    def test_a_node_has_the_name_that_the_file_gives_it(self, files):
        with files.built(self.TEXT) as root:
            lines = [(node.depth, node.kind, node.name, node.origin) for node in nodes_of(root)]

        inside = [
            (2, "Same", "hi", "tree.xml:5"),
            (3, "ScriptConditions", "_skipIf _post", "tree.xml:5"),
            (4, "Say", "Say", "tree.xml:5"),
        ]
        assert lines == [
            (0, "All", "first", "tree.xml:2"),
            (1, "Say", "Say", "tree.xml:3"),
            (1, "Say", "hi/there. you", "tree.xml:3"),
            (1, "SubTree", "S", "tree.xml:4"),
            *inside,
            (1, "SubTree", "again", "tree.xml:4"),
            *inside,
        ]

    def test_what_one_tree_writes_another_one_of_the_file_does_not_read(self, files):
        text = _main('<All><Say name="s" text="{x}"/><Put value="5" to="{x}"/></All>')

        assert [{"s": "nothing"}, {"s": "nothing"}] == [files.ticked(text)[1] for _ in range(2)]

    def test_two_builds_are_alike(self, files):
        with files.built(self.TEXT) as one, files.built(self.TEXT) as other:
            assert nodes_of(one) == nodes_of(other)

    def test_each_build_has_nodes_of_its_own(self, files):
        tree = files.load(self.TEXT)

        assert not {*tree.build().iterate()} & {*tree.build().iterate()}

    def test_a_file_is_parsed_once_for_all_robots(self, files, monkeypatch):
        parsed = Mock(wraps=file_tree.read)
        monkeypatch.setattr(file_tree, "read", parsed)
        tree = files.load("<BehaviorTree ID='A'><Say/></BehaviorTree>")
        for _ in range(3):
            with Board().in_use:
                tree.build()

        assert parsed.call_count == 1

    def test_entries_of_one_tree_are_none_of_another(self, files):
        tree = files.load("<BehaviorTree ID='A'><All><Put value='1' to='{x}'/><Say text='{x}'/></All></BehaviorTree>")
        boards = [Board(), Board()]
        roots = []
        for board in boards:
            with board.in_use:
                roots.append(tree.build())
        with boards[0].in_use:
            roots[0].tick_once()

        assert ("/x" in boards[0].storage, "/x" in boards[1].storage) == (True, False)

    def test_a_node_whose_class_cannot_be_used_is_one_line(self, files):
        class Broken(files.nodes["Say"]):
            def __init__(self, name, behaviour_class_name):
                raise RuntimeError(f"no battery for {name} of {behaviour_class_name}")

        files.nodes["Broken"] = Broken
        with pytest.raises(TreeError, match=r"^tree\.xml: <Broken>: RuntimeError: no battery for Broken of") as caught:
            files.load(_main("<Broken/>"))

        assert len(str(caught.value).splitlines()) == 1


class TestPorts:
    """Ports have the values and keys of the file."""

    @pytest.mark.parametrize("text", ["", "a", "1.5", "a/b.c", "ü; x", " ", "'", "__const", "None"])
    def test_a_value_is_read_as_it_is_written(self, files, text):
        assert files.ticked(_main(f'<Say name="s" text="{text}"/>'))[1].get("s", "") == text

    @pytest.mark.parametrize(
        ("writes", "reads", "key"),
        [
            ("{x}", "{x}", "/x"),
            ("x", "{ x }", "/x"),
            ("{x-Y_9}", "{x-Y_9}", "/x-Y_9"),
            ("{@x}", "{x}", "/x"),
            ("{x}", "{@x}", "/x"),
            ("{=}", "{to}", "/to"),
            ("{größe}", "{größe}", "/größe"),
        ],
    )
    def test_a_key_is_one_entry_however_it_is_written(self, files, writes, reads, key):
        """{=} is the port's own name; {@key} is in the outermost tree, where we are."""
        body = f'<All><Put value="5" to="{writes}"/><Say name="s" text="{reads}"/></All>'

        assert files.ticked(_main(body)) == ({key: "5"}, {"s": "5"})

    def test_a_port_of_which_the_file_says_nothing_may_lead_to_a_key(self, files):
        with files.built(_main('<Go goal="1;2"/>')) as root:
            client = root.blackboard_client
            assert client.remappings[client.absolute_name("note")] == "/note"

    def test_values_are_there_from_the_start(self, files):
        text = _main('<All><Say name="s" text="{x}"/></All>')

        assert files.ticked(text, values={"x": "given"})[1] == {"s": "given"}


class TestSubtrees:
    """A subtree has its own blackboard and shares the declared entries."""

    MOVE = _tree(
        "MoveRobot",
        '<All><Say name="s" text="{target}"/><Script code=" result:=\'goal reached\' "/><Script code="own:=1"/></All>',
    )

    def test_ports_lead_to_entries_of_the_parent_tree(self, files):
        body = (
            "<All><Script code=\" move_goal:='1;2;3' \"/>"
            '<SubTree ID="MoveRobot" target="{move_goal}" result="{move_result}"/>'
            '<Say name="end" text="{move_result}"/></All>'
        )

        assert files.ticked(_main(body, self.MOVE)) == (
            {"/move_goal": "1;2;3", "/move_result": "goal reached", "/MoveRobot/own": 1},
            {"s": "1;2;3", "end": "goal reached"},
        )

    def test_each_use_has_a_blackboard_of_its_own(self, files):
        body = '<All><SubTree ID="MoveRobot" target="a"/><SubTree ID="MoveRobot" target="b"/>'
        body += '<SubTree ID="MoveRobot" name="to the/left.1" target="c"/></All>'

        entries, _ = files.ticked(_main(body, self.MOVE))
        assert {key: value for key, value in entries.items() if key.endswith("target")} == {
            "/MoveRobot/target": "a",
            "/MoveRobot_2/target": "b",
            "/to_the_left_1/target": "c",
        }

    def test_autoremap_shares_each_key_by_its_name(self, files):
        inside = '<All><Put value="1" to="a"/><Put value="2" to="_b"/><Put value="3" to="c"/>'
        inside += '<Say name="s" text="{d}"/></All>'
        body = '<SubTree ID="S" name="s1" _autoremap="true" c="{other}" d="text"/>'

        assert files.ticked(_main(body, _tree("S", inside))) == (
            {"/a": "1", "/s1/_b": "2", "/other": "3", "/s1/d": "text"},
            {"s": "text"},
        )

    def test_autoremap_reaches_through_subtrees(self, files):
        inner = _tree("I", '<All><Put value="1" to="x"/><Put value="2" to="y"/></All>')
        outer = _tree("O", '<SubTree ID="I" _autoremap="1" y="{z}"/>')

        entries, _ = files.ticked(_main('<SubTree ID="O" _autoremap="1"/>', outer, inner))
        assert entries == {"/x": "1", "/z": "2"}

    def test_without_autoremap_nothing_is_shared(self, files):
        outer = _tree("O", '<SubTree ID="I" _autoremap="true"/>')

        entries, _ = files.ticked(_main('<SubTree ID="O"/>', outer, _tree("I", '<Put value="1" to="x"/>')))
        assert entries == {"/O/x": "1"}

    def test_equals_sign_shares_a_port_by_its_name(self, files):
        entries, _ = files.ticked(_main('<SubTree ID="S" x="{=}"/>', _tree("S", '<Put value="1" to="x"/>')))

        assert entries == {"/x": "1"}

    def test_an_at_sign_means_the_outermost_tree(self, files):
        inner = _tree("I", '<All><Put value="1" to="{@x}"/><Script code="@y := 2; x := 3"/></All>')
        outer = _tree("O", '<SubTree ID="I"/>')

        entries, _ = files.ticked(_main('<SubTree ID="O"/>', outer, inner))
        assert entries == {"/x": "1", "/y": 2, "/O/I/x": 3}

    def test_a_value_for_a_port_is_an_entry_of_the_subtree(self, files):
        inside = '<All><Say name="before" text="{x}"/><Put value="new" to="x"/><Say name="after" text="{x}"/></All>'

        entries, said = files.ticked(_main('<SubTree ID="S" x="old"/>', _tree("S", inside)))
        assert (entries, said) == ({"/S/x": "new"}, {"before": "old", "after": "new"})

    def test_the_model_of_a_subtree_says_what_is_not_mentioned(self, files):
        model = (
            '<TreeNodesModel><SubTree ID="S"><input_port name="a" default="1"/><output_port name="b" default="{c}"/>'
        )
        model += '<inout_port name="d" default="2"/></SubTree></TreeNodesModel>'
        inside = '<All><Say name="s" text="{a}"/><Put value="x" to="b"/><Say name="t" text="{d}"/></All>'

        entries, said = files.ticked(_main('<SubTree ID="S" a="9"/>', _tree("S", inside), model))
        assert (entries, said) == ({"/S/a": "9", "/c": "x", "/S/d": "2"}, {"s": "9", "t": "2"})

    def test_scripts_around_a_subtree_are_of_the_parent_tree(self, files):
        body = '<All><Script code="x := 1"/><SubTree ID="S" name="S" _skipIf="x == 1"/></All>'
        with files.built(_main(body, _tree("S", '<Put value="0" to="x"/>'))) as root:
            for node in root.iterate():
                node.setup()
            root.tick_once()

            assert root.children[1].child.status is Status.INVALID

    def test_a_subtree_does_as_its_tree(self, files):
        files.nodes = {**files.nodes, **registry()}
        for node, status in (("AlwaysSuccess", Status.SUCCESS), ("AlwaysFailure", Status.FAILURE)):
            with files.built(_main('<SubTree ID="S"/>', _tree("S", f"<{node}/>"))) as root:
                root.tick_once()
                assert root.status is status
