"""Expressions of overlays: ``${levels.charge[charge][i-1]}``, and ``$i`` for a single name.

An expression consists of names, keys after dots or in brackets, numbers, quoted texts and arithmetic. Python's parser
reads it, but all other Python is rejected.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Final

from hmrsim.diagnostics import instead, shortened, shown


class OverlayFlaw(ValueError):
    """An error in an overlay; the message has the reason and a remedy. The caller adds the file and line."""


class UnknownPart(OverlayFlaw):
    """A table lacks an entry; the message names the table and the key."""


Names = Mapping[str, Any]
"""The values that an expression can use, by name."""

_REFERENCE: Final = re.compile(r"\$(?:(?P<escaped>\$)|\{(?P<expression>[^{}]*)\}|(?P<name>[A-Za-z_]\w*))", re.ASCII)
_MAX_LENGTH: Final = 500
_MAX_DEPTH: Final = 100
_MAX_TEXT: Final = 10_000
"""The maximum number of characters that expressions insert into a text: a long value may be inserted many times."""

_OPERATIONS: Final[Mapping[type[ast.operator], Callable[[Any, Any], Any]]] = MappingProxyType(
    {
        ast.Add: operator.add,
        ast.Sub: operator.sub,
        ast.Mult: operator.mul,
        ast.Div: operator.truediv,
        ast.FloorDiv: operator.floordiv,
        ast.Mod: operator.mod,
    }
)


def substituted(value: Any, names: Names) -> Any:
    """Return a value with the expressions in its texts replaced, also inside lists and mappings.

    A text that consists of a single expression becomes the value of the expression. In longer texts, each expression
    is replaced by its value as text. ``$$`` is a dollar sign.

    Raises:
        OverlayFlaw: An expression has no value.
    """
    if isinstance(value, str):
        return _in_text(value, names) if "$" in value else value
    if isinstance(value, list):
        return [substituted(part, names) for part in value]
    if isinstance(value, dict):
        return {in_key(key, names): substituted(part, names) for key, part in value.items()}
    return value


def in_key(key: str, names: Names) -> str:
    """Return a key with its expressions replaced by their texts.

    Raises:
        OverlayFlaw: An expression has no value.
    """
    return str(_in_text(key, names)) if "$" in key else key


def evaluate(expression: str, names: Names) -> Any:
    """Return the value of an expression without ``${}``.

    Raises:
        OverlayFlaw: The expression has no value.
    """
    return _evaluated(_parsed(expression), names)


@lru_cache(maxsize=4096)
def names_in(expression: str) -> frozenset[str]:
    """Return the names in an expression.

    Raises:
        OverlayFlaw: The expression is invalid.
    """
    return frozenset(node.id for node in ast.walk(_parsed(expression)) if isinstance(node, ast.Name))


def names_used_in(value: Any) -> frozenset[str]:
    """Return the names in the expressions of a value, also inside lists and mappings.

    Raises:
        OverlayFlaw: An expression is invalid.
    """
    if isinstance(value, str):
        if "$" not in value:
            return frozenset()
        matches = (match for match in _REFERENCE.finditer(value) if not match["escaped"])
        return frozenset().union(*(names_in(match["name"] or match["expression"]) for match in matches))
    if isinstance(value, Mapping):
        return frozenset().union(*map(names_used_in, value), *map(names_used_in, value.values()))
    if isinstance(value, (list, tuple)):
        return frozenset().union(*map(names_used_in, value))
    return frozenset()


@lru_cache(maxsize=4096)
def parts_in(expression: str) -> tuple[str, ...]:
    """Return the parts of values that an expression uses, such as ``orders.lead_time.mean``.

    Raises:
        OverlayFlaw: The expression is invalid.
    """
    parts: list[str] = []

    def visit(node: ast.AST) -> None:
        if isinstance(node, (ast.Attribute, ast.Subscript)):
            parts.append(ast.unparse(node))
        if not isinstance(node, ast.Attribute):
            for child in ast.iter_child_nodes(node):
                visit(child)

    visit(_parsed(expression))
    return tuple(parts)


def _in_text(text: str, names: Names) -> Any:
    whole = _REFERENCE.fullmatch(text)
    if whole and not whole["escaped"]:
        return _value(whole, names)
    parts: list[str] = []
    length = end = 0
    for match in _REFERENCE.finditer(text):
        parts += text[end : match.start()], "$" if match["escaped"] else _as_text(_value(match, names))
        end = match.end()
        length += len(parts[-1])
        if length > _MAX_TEXT:
            raise OverlayFlaw(f"{shown(text)} becomes a text of more than {_MAX_TEXT:,} characters")
    return "".join((*parts, text[end:]))


def _as_text(value: object) -> str:
    if isinstance(value, (dict, list)):
        raise OverlayFlaw(f"{shown(value)} can't be part of a text")
    return str(value)


def _value(match: re.Match[str], names: Names) -> Any:
    text: str = match["name"] or match["expression"]
    try:
        return _evaluated(_parsed(text), names)
    except OverlayFlaw as error:
        raise OverlayFlaw(f"{shortened(match[0])}: {error}") from None


@lru_cache(maxsize=4096)
def _parsed(text: str) -> ast.expr:
    if len(text) > _MAX_LENGTH:
        raise OverlayFlaw(f"is longer than {_MAX_LENGTH} characters")
    try:
        parsed = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise OverlayFlaw(
            "is no expression; expected a name such as levels.speed[speed], or a sum of numbers"
        ) from None
    level: list[ast.AST] = [parsed]
    for _ in range(_MAX_DEPTH):
        for node in level:
            if isinstance(node, ast.Call):
                raise OverlayFlaw(
                    f"{shortened(ast.unparse(node.func))!r} is called, but an expression has no functions, only names, "
                    "keys, numbers and + - * / // %; calculate it elsewhere, as in a table or from exported results"
                )
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return parsed
    raise OverlayFlaw(f"is nested deeper than {_MAX_DEPTH}")


def _evaluated(node: ast.expr, names: Names) -> Any:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float, str)):
        return node.value
    if isinstance(node, ast.Name):
        if node.id not in names:
            raise OverlayFlaw(f"there is no {node.id!r}{instead(node.id, names)}")
        return names[node.id]
    if isinstance(node, ast.Attribute):
        return _part(_evaluated(node.value, names), node.attr, node.value)
    if isinstance(node, ast.Subscript):
        return _part(_evaluated(node.value, names), _evaluated(node.slice, names), node.value)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_number(_evaluated(node.operand, names))
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        return _result(node, _number(_evaluated(node.left, names)), _number(_evaluated(node.right, names)))
    raise OverlayFlaw(f"{ast.unparse(node)!r} is more than names, keys, numbers and + - * / // %")


def _number(value: object) -> int | float:
    if value is None:
        raise OverlayFlaw("there is no value to calculate with")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise OverlayFlaw(f"{shown(value)} is no number to calculate with")
    return value


def _result(node: ast.BinOp, left: float, right: float) -> int | float:
    try:
        value: int | float = _OPERATIONS[type(node.op)](left, right)
        is_finite = math.isfinite(value)
    except ArithmeticError as error:
        raise OverlayFlaw(f"{shortened(ast.unparse(node))}: {error}") from None
    if not is_finite:
        raise OverlayFlaw(f"{shortened(ast.unparse(node))} is not finite")
    return value


def _part(whole: object, key: object, node: ast.expr) -> Any:
    """Return the entry of a mapping or list at a key; a key of a mapping may also be written as text.

    *node* is the expression of the mapping or list, for errors.
    """
    if isinstance(whole, Mapping):
        for candidate in (key, str(key)):
            if candidate in whole:
                return whole[candidate]
        raise UnknownPart(f"{ast.unparse(node)} has no {shown(key)}{instead(str(key), map(str, whole), verb='it has')}")
    if isinstance(whole, list):
        if isinstance(key, bool) or not isinstance(key, int):
            raise OverlayFlaw(f"{ast.unparse(node)} is a list, of which {shown(key)} is no index")
        if not 0 <= key < len(whole):
            raise OverlayFlaw(f"{ast.unparse(node)} has {len(whole)} entries, from 0 on; there is none at {key}")
        return whole[key]
    raise OverlayFlaw(f"{ast.unparse(node)} is {shown(whole)}, which has no parts")
