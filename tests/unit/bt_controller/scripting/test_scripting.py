"""The script language of BehaviorTree.CPP."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_controller.scripting.parser import ScriptError, parse
from tests.cases import case


class Board(dict):
    """A blackboard that is a dictionary."""

    def set(self, name, value):
        self[name] = value


def value_of(text, **entries):
    return parse(text).run(Board(entries))


def after(text, **entries):
    board = Board(entries)
    parse(text).run(board)
    return dict(board)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("42", 42),
        ("0x1F", 31),
        ("0XfF", 255),
        ("2.5", 2.5),
        ("2e3", 2000.0),
        ("2.5e-1", 0.25),
        ("-3", -3),
        ("+3", 3),
        ("'a \"b\"'", 'a "b"'),
        ('"it\'s"', "it's"),
        ("''", ""),
        ("true", True),
        ("false", False),
    ],
)
def test_literals(text, value):
    assert (value, type(value)) == (value_of(text), type(value_of(text)))


VALUES = {
    "arithmetic": [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("10 - 4 - 3", 3),
        ("12 / 3 / 2", 2),
        ("7 / 2", 3.5),
        ("-2 * -3", 6),
        ("- (2 + 3)", -5),
        ("1 - -1", 2),
        ("true + 1", 2),
    ],
    "bits": [
        ("6 & 3", 2),
        ("6 | 3", 7),
        ("6 ^ 3", 5),
        ("~5", -6),
        ("1 | 6 & 3", 3),
        ("2.0 & 3", 2),
        ("(1 + 2) & 3", 3),
    ],
    "texts are joined": [
        ("'a' + 'b'", "ab"),
        ("'a' .. 'b'", "ab"),
        ("'a' .. 1", "a1"),
        ("2.5 .. 'a'", "2.5a"),
        ("'a' .. 1 + 2", "a3"),
    ],
    "comparisons": [
        ("1 == 1.0", True),
        ("1 != 2", True),
        ("1 < 2", True),
        ("2 <= 1", False),
        ("2 > 1", True),
        ("1 >= 2", False),
        ("'a' == 'a'", True),
        ("'a' < 'b'", True),
        ("0.1 + 0.2 == 0.3", True),
        ("0.1 + 0.2 != 0.3", False),
        ("1 < 2 < 3", True),
        ("1 < 3 < 2", False),
        ("1 + 1 == 2", True),
    ],
    "&& and || bind equally, from left to right": [
        ("true && false", False),
        ("true || false", True),
        ("!false", True),
        ("!'a'", False),
        ("2 && 'a'", True),
        ("1 < 2 && 2 < 3", True),
        ("true || true && false", False),
    ],
    "choices": [
        ("true ? 1 : 2", 1),
        ("0 ? 1 : 2", 2),
        ("'' ? 1 : 2", 2),
        ("1 > 2 ? 'a' : 'b'", "b"),
        ("true ? (false ? 1 : 2) : 3", 2),
        ("true ? false ? 1 : 2 : 3", 2),
        ("true ? 1 : missing", 1),
    ],
    "statements": [("1; 2; 3", 3)],
}


@pytest.mark.parametrize("values", VALUES.values(), ids=VALUES)
def test_an_expression_has_a_value(values):
    for text, value in values:
        with case(text):
            assert value == value_of(text)
            assert isinstance(value, bool) is isinstance(value_of(text), bool)


@pytest.mark.parametrize("text", ["1 + 2 & 3", "1 | 2 * 3", "!true + 1", "-~1"])
def test_bits_and_arithmetic_need_parentheses(text):
    """BehaviorTree.CPP leaves open how they would bind, and so do we."""
    with pytest.raises(ScriptError, match="parentheses where arithmetic and bitwise operators"):
        parse(text)


@pytest.mark.parametrize(
    ("entry", "text", "value"),
    [
        ("3", "entry == 3", True),
        ("10", "entry > 9", True),
        ("2.5", "2.5 == entry", True),
        ("true", "entry == 1", True),
        ("false", "entry == 0", True),
        ("10", "entry > '9'", False),
        ("3", "entry + 1", 4),
        ("3", "-entry", -3),
    ],
)
def test_a_text_that_reads_as_a_number_counts_as_one_beside_a_number(entry, text, value):
    """So that what a file or a user puts on the blackboard can be compared; two texts are compared as texts."""
    assert value == value_of(text, entry=entry)


def test_logic_looks_at_both_sides():
    """As in BehaviorTree.CPP: also where the first says it all."""
    assert {"a": 1, "b": 2} == after("true || (a := 1); false && (b := 2)")


def test_names_are_entries():
    assert 5 == value_of("own + @main", **{"own": 2, "@main": 3})


def test_the_names_are_known_beforehand():
    script = parse("b := a + @c; a = b; b += 1")

    assert (("b", "a", "@c"), ("b", "a")) == (script.names, script.changed)


@pytest.mark.parametrize(
    ("text", "value"),
    [("x := 1", 1), ("x = 1", 1), ("x += 2", 7), ("x -= 2", 3), ("x *= 2", 10), ("x /= 2", 2.5)],
)
def test_assignments(text, value):
    assert {"x": value} == after(text, x=5)
    assert value == value_of(text, x=5)


def test_only_one_assignment_makes_an_entry():
    assert {"x": 1} == after("x := 1")
    with pytest.raises(ScriptError, match=r"script 'x = 1': no entry 'x'; ':=' creates one"):
        after("x = 1")
    with pytest.raises(ScriptError, match="no entry 'x'"):
        after("x += 1")


def test_anything_can_be_passed_on():
    pose = object()

    assert {"one": pose, "other": pose} == after("other := one", one=pose)


def test_statements_follow_each_other():
    assert {"a": 1, "b": 2, "c": 3} == after("a := 1; b := a + 1; c := a + b;")


def test_whole_numbers_stay_whole():
    """Ports for whole numbers take them; a quotient is one if it can."""
    assert int is type(value_of("6 / 3 + 2 * 4"))
    assert [float, float] == [type(value_of(text)) for text in ("6.0 / 3", "6 / 3.0")]


def test_a_number_of_more_than_64_bits_is_a_float():
    """The same holds for BehaviorTree.CPP, where it is a double from the start."""
    assert (float, 2.0**64) == (type(value_of("x * x", x=2**32)), value_of("x * x", x=2**32))


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("", r"script '': character 1: expected a statement, got its end"),
        (";", "character 2: expected a statement"),
        ("1 +", "character 4: expected a value, got its end"),
        ("1 2", r"character 3: expected an operator or ';', got '2'"),
        ("(1", r"character 3: expected '\)', got its end"),
        ("a ? 1", "character 6: expected ':'"),
        ("1 = 2", r"character 3: expected the name of an entry before '='"),
        ("(a) := 2", "expected the name of an entry before ':='"),
        ("a = b = c", r"character 7: expected an operator or ';', got '='"),
        ("'a", r"character 1: expected a number, a name, a text in quotes or an operator, got \"'a\""),
        ("3apples", "character 1: expected a number, .* got '3apples'"),
        ("1.5.2", "character 1: expected a number"),
        ("a # b", "character 3: expected a number, a name, a text in quotes or an operator, got '# b'"),
        ("+a", "character 2: expected a number, got 'a'"),
        ("{key}", "character 1: expected a number, a name"),
        ("9223372036854775808", "expected a number of 64 bits"),
        ("(" * 21 + "1" + ")" * 21, "something simpler"),
        ("-" * 30 + "a", "something simpler"),
        ("+".join(["a"] * 200), "something shorter"),
    ],
)
def test_a_malformed_script_is_an_error(text, error):
    with pytest.raises(ScriptError, match=error):
        parse(text)


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("missing", "script 'missing': 'missing' has no value yet"),
        ("'a' + 1", "'a' is not a number"),
        ("'a' < 1", "'a' is not a number"),
        ("1 / 0", "division by zero"),
        ("1.5 & 1", "1.5 is not a 64-bit integer"),
        ("1e300 & 1", "is not a 64-bit integer"),
        ("~'a'", "'a' is not a number"),
        ("thing + 1", "a list is not a number"),
        ("thing == thing", "a list is not a number"),
        ("thing ? 1 : 2", "a list is neither true nor false"),
        ("'a' .. thing", "a list is neither a text nor a number"),
        ("huge * 1.0", "a number is too large"),
    ],
)
def test_a_script_that_can_t_be_run_is_an_error(text, error):
    with pytest.raises(ScriptError, match=error):
        value_of(text, thing=[], huge=10**400)


_PIECES = st.lists(st.sampled_from([*"()+-*/<>=!&|^~?:;.'\" ", "a", "@b", "1", "2.5", "0x1", "'t'", ":=", "true"]))


@given(st.one_of(st.text(), _PIECES.map("".join), st.integers(0, 2000).map(lambda n: "(" * n + "a" + "-a" * n)))
def test_nothing_but_a_script_error_is_raised(text):
    with suppress(ScriptError):
        parse(text).run(Board({"a": "text", "@b": 3}))


_NUMBERS = st.integers(0, 1000) | st.floats(0.0, 1000.0).filter(lambda x: "e" not in repr(x))
_EXPRESSIONS = st.recursive(
    _NUMBERS.map(str),
    lambda part: st.one_of(
        st.builds("{} {} {}".format, part, st.sampled_from("+-*"), part),
        part.map("({})".format),
        part.map("-({})".format),
    ),
    max_leaves=12,
)


@given(_EXPRESSIONS)
def test_arithmetic_is_python_s(text):
    assert pytest.approx(eval(text)) == value_of(text)
