"""The terms of scripts, which form an expression tree."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

from bt_controller.scripting.values import OPERATIONS, complement, inverted, negated, truth


class Environment(Protocol):
    """The entries that a script can access."""

    def get(self, name: str) -> Any:
        """Return the value of an entry; None if there is none."""

    def set(self, name: str, value: Any) -> None:
        """Change or create an entry."""


class Term(NamedTuple):
    """A part of a script.

    Attributes:
        evaluate: Returns its value; raises ValueError, or OverflowError for numbers that are too large.
        depth: The depth of nested terms.
        kind: The kind of operators that must not be mixed with others.
        name: The name, if the term is an entry alone.
    """

    evaluate: Callable[[Environment], Any]
    depth: int = 1
    kind: str = ""
    name: str = ""


def literal(value: Any) -> Term:
    """Return a literal."""
    return Term(lambda _: value)


def lookup(name: str) -> Callable[[Environment], Any]:
    """Return the value of an entry."""

    def evaluate(environment: Environment) -> Any:
        value = environment.get(name)
        if value is None:
            raise ValueError(f"{name!r} has no value yet")
        return value

    return evaluate


def unary(sign: str, operand: Term) -> Callable[[Environment], Any]:
    """Return a unary operation."""
    operation = {"-": negated, "~": complement, "!": inverted}[sign]
    return lambda environment: operation(operand.evaluate(environment))


def binary(sign: str, left: Term, right: Term) -> Callable[[Environment], Any]:
    """Return a binary operation."""
    operation = OPERATIONS[sign]
    return lambda environment: operation(left.evaluate(environment), right.evaluate(environment))


def comparison(signs: Sequence[str], operands: Sequence[Term]) -> Callable[[Environment], Any]:
    """Return a chain of comparisons, each of an operand with the next."""

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
    """Return a conditional of two terms."""
    return lambda environment: (one if truth(condition.evaluate(environment)) else other).evaluate(environment)


def assignment(name: str, sign: str, value: Term) -> Callable[[Environment], Any]:
    """Return an assignment to an entry, whose value is the assigned one."""

    def evaluate(environment: Environment) -> Any:
        before = environment.get(name)
        if before is None and sign != ":=":
            raise ValueError(f"no entry {name!r}; ':=' creates one")
        result = value.evaluate(environment)
        if sign not in (":=", "="):
            result = OPERATIONS[sign[0]](before, result)
        environment.set(name, result)
        return result

    return evaluate
