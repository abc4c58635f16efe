"""The operators of scripts on values, as in BehaviorTree.CPP, and the terms that apply them.

Values are numbers, texts, truth values (1 and 0 as numbers), and any other entry of the blackboard, which can only be
passed on. A text that reads as a number, ``true`` or ``false`` counts as that beside a number.

There are two differences to BehaviorTree.CPP. Whole numbers stay whole as long as they fit into 64 bits, so that ports
for whole numbers take them. A division by zero is an error instead of an infinity.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any, Final, NamedTuple, Protocol

_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_WHOLE: Final = re.compile(r"[+-]?\d{1,18}")
_BITS: Final = 63
_EPSILON: Final = 2.0**-23
"""The difference below which BehaviorTree.CPP considers numbers equal."""


def as_number(value: object) -> float | None:
    """Return a value as a number; None if it is not one."""
    if isinstance(value, (int, float)):
        return value
    if not isinstance(value, str):
        return None
    text = value.strip()
    if text in ("true", "false"):
        return text == "true"
    if _WHOLE.fullmatch(text):
        return int(text)
    return float(text) if _NUMBER.fullmatch(text) else None


def truth(value: object) -> bool:
    """Return whether a value counts as true: a number that is not zero, or a text that is neither zero nor empty.

    Raises:
        ValueError: The value is something else.
    """
    number = as_number(value)
    if number is not None:
        return number != 0
    if isinstance(value, str):
        return value != ""
    raise ValueError(f"{_shown(value)} is neither true nor false")


def same(one: object, other: object) -> bool:
    """Return whether two values are equal: two texts as texts or as numbers, anything else as numbers only."""
    if one == other and isinstance(one, str):
        return True
    left, right = as_number(one), as_number(other)
    return left is not None and right is not None and _equal(left, right)


def _equal(left: float, right: float) -> bool:
    return left == right or abs(left - right) <= _EPSILON


def _number(value: object) -> float:
    number = as_number(value)
    if number is None:
        raise ValueError(f"{_shown(value)} is not a number")
    return number


def _whole(value: object) -> int:
    number = _number(value)
    if not math.isfinite(number) or number != int(number) or int(number).bit_length() > _BITS:
        raise ValueError(f"{_shown(value)} is not a 64-bit integer")
    return int(number)


def _shown(value: object) -> str:
    if isinstance(value, (str, int, float)):
        return f"{value!r:.80}"
    return f"a {type(value).__name__}"


def _bounded(number: float) -> float:
    if isinstance(number, int) and number.bit_length() > _BITS:
        return float(number)
    return number


def _calculated(operation: Callable[[float, float], float], left: object, right: object) -> float:
    return _bounded(operation(_number(left), _number(right)))


def _sum(left: object, right: object) -> Any:
    if isinstance(left, str) and isinstance(right, str):
        return left + right
    return _calculated(operator.add, left, right)


def _quotient(left: float, right: float) -> float:
    if right == 0:
        raise ValueError("division by zero")
    if isinstance(left, int) and isinstance(right, int) and left % right == 0:
        return left // right
    return left / right


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, int, float)):
        return str(value)
    raise ValueError(f"{_shown(value)} is neither a text nor a number")


def _bitwise(operation: Callable[[int, int], int], left: object, right: object) -> int:
    return operation(_whole(left), _whole(right))


def _compared(operation: Callable[[Any, Any], bool], left: object, right: object) -> bool:
    if isinstance(left, str) and isinstance(right, str):
        return operation(left, right)
    return operation(_number(left), _number(right))


def _same_number(left: Any, right: Any) -> bool:
    return left == right if isinstance(left, str) else _equal(left, right)


OPERATIONS: Final[Mapping[str, Callable[[Any, Any], Any]]] = MappingProxyType(
    {
        "+": _sum,
        "-": partial(_calculated, operator.sub),
        "*": partial(_calculated, operator.mul),
        "/": partial(_calculated, _quotient),
        "..": lambda left, right: _text(left) + _text(right),
        "&": partial(_bitwise, operator.and_),
        "|": partial(_bitwise, operator.or_),
        "^": partial(_bitwise, operator.xor),
        "&&": lambda left, right: truth(left) & truth(right),
        "||": lambda left, right: truth(left) | truth(right),
        "==": partial(_compared, _same_number),
        "!=": partial(_compared, lambda left, right: not _same_number(left, right)),
        "<": partial(_compared, operator.lt),
        ">": partial(_compared, operator.gt),
        "<=": partial(_compared, operator.le),
        ">=": partial(_compared, operator.ge),
    }
)
"""The operators by sign. They raise ValueError, and OverflowError for numbers that are too large."""
_UNARY: Final[Mapping[str, Callable[[Any], Any]]] = MappingProxyType(
    {
        "-": lambda value: _bounded(-_number(value)),
        "~": lambda value: ~_whole(value),
        "!": lambda value: not truth(value),
    }
)


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
    operation = _UNARY[sign]
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
