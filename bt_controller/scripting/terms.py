"""What scripts are made of: terms that can be evaluated, each made of others."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from bt_controller.scripting.values import OPERATIONS, complement, inverted, negated, truth

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


class Environment(Protocol):
    """Where a script finds its names."""

    def get(self, name: str) -> Any:
        """Return the value of an entry; None if there is none."""

    def set(self, name: str, value: Any) -> None:
        """Change an entry, or make it."""


class Term(NamedTuple):
    """A part of a script.

    Attributes:
        evaluate: Returns its value; raises ValueError, or OverflowError for numbers that are too large.
        depth: How many terms are in each other.
        kind: Of operators that must not be mixed with others.
        name: Of an entry, if it is nothing else.
    """

    evaluate: Callable[[Environment], Any]
    depth: int = 1
    kind: str = ""
    name: str = ""


def literal(value: Any) -> Term:
    """Return a value that is written in the script."""
    return Term(lambda _: value)


def lookup(name: str) -> Callable[[Environment], Any]:
    """Return the value of an entry."""

    def evaluate(environment: Environment) -> Any:
        value = environment.get(name)
        if value is None:
            raise ValueError(f"{name!r} has no value: nothing has written it so far")
        return value

    return evaluate


def unary(sign: str, operand: Term) -> Callable[[Environment], Any]:
    """Return what a sign makes of an operand."""
    operation = {"-": negated, "~": complement, "!": inverted}[sign]
    return lambda environment: operation(operand.evaluate(environment))


def binary(sign: str, left: Term, right: Term) -> Callable[[Environment], Any]:
    """Return what an operator makes of two operands."""
    operation = OPERATIONS[sign]
    return lambda environment: operation(left.evaluate(environment), right.evaluate(environment))


def comparison(signs: Sequence[str], operands: Sequence[Term]) -> Callable[[Environment], Any]:
    """Return whether each operand compares with the next as its sign says."""

    def evaluate(environment: Environment) -> bool:
        left = operands[0].evaluate(environment)
        for sign, operand in zip(signs, operands[1:], strict=True):
            right = operand.evaluate(environment)
            if not OPERATIONS[sign](left, right):
                return False
            left = right
        return True

    return evaluate


def choice(condition: Term, one: Term, other: Term) -> Callable[[Environment], Any]:
    """Return one of two terms, as a condition says."""
    return lambda environment: (one if truth(condition.evaluate(environment)) else other).evaluate(environment)


def assignment(name: str, sign: str, value: Term) -> Callable[[Environment], Any]:
    """Return a value after writing it to an entry."""

    def evaluate(environment: Environment) -> Any:
        before = environment.get(name)
        if before is None and sign != ":=":
            raise ValueError(f"there is no entry {name!r} yet; ':=' makes one")
        result = value.evaluate(environment)
        if sign not in (":=", "="):
            result = OPERATIONS[sign[0]](before, result)
        environment.set(name, result)
        return result

    return evaluate
