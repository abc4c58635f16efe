"""Whatever is in a file: a tree, or an error that says what is wrong."""

from __future__ import annotations

from contextlib import suppress
from xml.sax.saxutils import quoteattr

from hypothesis import given
from hypothesis import strategies as st

from bt_controller.errors import TreeError
from bt_controller.nodes import registry
from bt_controller.running.snapshot import nodes_of
from tests.profiles import examples

_MANY = examples(150, share_fixtures=True)

GOOD = b"""\
<?xml version="1.0"?>
<root BTCPP_format="4" main_tree_to_execute="A">
  <BehaviorTree ID="A"><Fallback name="f"><Sequence>
    <SetBlackboard value="1;2" output_key="goal"/><Script code="n := 2 * 3"/>
    <SubTree ID="B" goal="{goal}" _autoremap="true" _skipIf="n &lt; 3"/></Sequence>
    <Inverter><AlwaysSuccess _onSuccess="@m = 1"/></Inverter></Fallback></BehaviorTree>
  <BehaviorTree ID="B"><NavigateToPose goal="{goal}" error_code_id="{code}"/></BehaviorTree>
  <TreeNodesModel><SubTree ID="B"><input_port name="goal" default="{=}"/></SubTree></TreeNodesModel>
</root>"""

_SIGNS = rb"""< > / " ' { } {=} {@} = & &#0; &#10; @ _ ; n A B ID name SubTree __const_ <include """
_WORDS = st.sampled_from([*_SIGNS.split(), b"<!DOCTYPE a>", b"<include path='tree.xml'/>", b"\xff", b"\x00", b" "])


def _load(files, data):
    """Load a file; any error other than a TreeError is a bug."""
    (files.folder / "tree.xml").write_bytes(data)
    files.nodes = registry()
    with suppress(TreeError):
        files.read()


def test_the_file_that_is_changed_is_a_tree(files):
    """Or the changes would show nothing."""
    (files.folder / "tree.xml").write_bytes(GOOD)
    files.nodes = registry()
    files.read()

    assert files.unset == ()


@given(data=st.binary(max_size=300))
@_MANY
def test_any_bytes_are_a_tree_or_a_tree_error(files, data):
    _load(files, data)


@given(changes=st.lists(st.tuples(st.integers(0, len(GOOD)), st.integers(0, 12), _WORDS), min_size=1, max_size=4))
@_MANY
def test_a_file_that_was_changed_is_a_tree_or_a_tree_error(files, changes):
    data = GOOD
    for place, gone, word in changes:
        data = data[:place] + word + data[place + gone :]
    _load(files, data)


_INPUTS = [(tag, port) for tag, node in registry().items() for port in node.input_ports()]
_NUMBERS = st.one_of(st.floats().map(str), st.integers().map(str))
_VALUES = st.one_of(_NUMBERS, st.lists(_NUMBERS, max_size=10).map(";".join), st.text(max_size=12))


@given(used=st.sampled_from(_INPUTS), text=_VALUES)
@_MANY
def test_any_value_of_any_port_is_read_or_refused(files, used, text):
    tag, port = used
    tree = f'<root><BehaviorTree ID="A"><{tag} {port}={quoteattr(text)}/></BehaviorTree></root>'
    _load(files, tree.encode("utf-8", "replace"))


def _element(tag, attributes, children):
    said = "".join(f" {key}={quoteattr(value)}" for key, value in attributes.items())
    return f"<{tag}{said}>{''.join(children)}</{tag}>"


_NAMES = st.dictionaries(
    st.just("name"), st.text(st.characters(codec="utf-8", categories=["L", "P", "Zs"]), max_size=8)
)
_TEXTS = st.one_of(
    st.sampled_from(["{a}", "{b}", "{=}", "{@c}", "{_d}"]),
    st.text(
        st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"], exclude_characters="{}\ufffe\uffff"), max_size=8
    ),
)
_SHARED = st.dictionaries(st.sampled_from(["a", "b", "d", "e"]), _TEXTS, max_size=3)
_AUTO = st.sampled_from([{}, {"_autoremap": "true"}, {"_autoremap": "0"}])
_SCRIPTS = st.dictionaries(
    st.sampled_from(["_skipIf", "_post"]), st.sampled_from(["a := 1", "b = a; @c", "true"]), max_size=2
)


def _trees(sub):
    """Return trees that may use the tree of an ID; None for none."""
    leaves = [
        st.builds(lambda n, s, t: _element("Say", {**n, **s, "text": t}, []), _NAMES, _SCRIPTS, _TEXTS),
        st.builds(lambda n, v: _element("Put", {**n, "value": v, "to": "{a}"}, []), _NAMES, _TEXTS),
    ]
    if sub is not None:
        uses = st.builds(
            lambda n, a, p, s: _element("SubTree", {"ID": sub, **n, **a, **p, **s}, []),
            _NAMES,
            _AUTO,
            _SHARED,
            _SCRIPTS,
        )
        leaves.append(uses)
    return st.recursive(
        st.one_of(leaves),
        lambda inner: st.one_of(
            st.builds(lambda n, c: _element("All", n, c), _NAMES, st.lists(inner, min_size=1, max_size=3)),
            st.builds(lambda n, s, c: _element("Same", {**n, **s}, [c]), _NAMES, _SCRIPTS, inner),
        ),
        max_leaves=6,
    )


_FILES = st.tuples(_trees("B"), _trees("C"), _trees(None)).map(
    lambda bodies: (
        '<root main_tree_to_execute="A">'
        + "".join(_element("BehaviorTree", {"ID": tree}, [body]) for tree, body in zip("ABC", bodies, strict=True))
        + "</root>"
    )
)


@given(text=_FILES)
@examples(100, share_fixtures=True)
def test_any_right_tree_is_built_and_two_builds_are_alike(files, text):
    with files.built(text) as one, files.built(text) as other:
        assert nodes_of(one) == nodes_of(other)
