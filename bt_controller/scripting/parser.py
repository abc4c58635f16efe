"""The script language of BehaviorTree.CPP 4, as in ``Script``, ``_skipIf`` and the like.

Statements are separated by ``;``. Names are entries of the blackboard, ``@name`` one of the outermost tree's.

- ``name := value`` makes an entry or changes it; ``=``, ``+=``, ``-=``, ``*=`` and ``/=`` change one that is there.
- ``+ - * /``, and ``..`` that joins texts; ``& | ^ ~`` on whole numbers. The two kinds are not mixed without
  parentheses; ``!`` binds as ``~`` does.
- ``== != < > <= >=``, also in chains: ``0 < x < 3``.
- ``&&`` and ``||`` bind equally, from left to right, and look at both sides.
- ``condition ? one : other``.
- Numbers (``3``, ``0x1F``, ``2.5e3``), texts (``'a'`` or ``"a"``, without escapes), ``true`` and ``false``.

There are no enumerations: a name without an entry is an error when the script runs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple, NoReturn

from bt_controller.scripting.values import Term, assignment, binary, choice, comparison, literal, lookup, unary
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from bt_controller.scripting.values import Environment

_TOKEN: Final = re.compile(
    r"""(?P<number>0[xX][0-9a-fA-F]+(?![\w.])|[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?(?![\w.]))
    |(?P<name>@?[^\W\d]\w*)
    |(?P<text>'[^']*'|"[^"]*")
    |(?P<sign>:=|==|!=|<=|>=|\+=|-=|\*=|/=|&&|\|\||\.\.|[-+*/&|^~!<>=?:;()])""",
    re.VERBOSE,
)
_ASSIGNMENTS: Final = (":=", "=", "+=", "-=", "*=", "/=")
_COMPARISONS: Final = ("==", "!=", "<", ">", "<=", ">=")
_ARITHMETIC: Final[Mapping[str, tuple[int, str]]] = MappingProxyType(
    {
        "..": (1, "arithmetic"),
        "+": (2, "arithmetic"),
        "-": (2, "arithmetic"),
        "*": (3, "arithmetic"),
        "/": (3, "arithmetic"),
        "|": (1, "bitwise"),
        "^": (1, "bitwise"),
        "&": (2, "bitwise"),
    }
)
"""The precedence and the kind of each operator."""

_MAX_DEPTH: Final = 20
"""The largest depth of nested parentheses and signs."""

_MAX_OPERATORS: Final = 100
"""The largest number of consecutive operators."""

_MAX_NUMBER: Final = 2**63


class ScriptError(HmrsimError):
    """A script can't be parsed or run; the text has the script, the position and the expected token."""


@dataclass(frozen=True)
class Script:
    """A script that can be run; made by `parse`.

    Attributes:
        names: The entries that it reads or changes, in order of their first use.
        changed: The entries that it changes.
    """

    text: str
    names: tuple[str, ...]
    changed: tuple[str, ...]
    statements: tuple[Callable[[Environment], Any], ...]

    def run(self, environment: Environment) -> Any:
        """Run all statements, and return the value of the last.

        Raises:
            ScriptError: An entry is missing, or an operator can't be used on a value.
        """
        value: Any = None
        try:
            for statement in self.statements:
                value = statement(environment)
        except ValueError as error:
            raise ScriptError(f"script {self.text!r:.200}: {error}") from None
        except OverflowError:
            raise ScriptError(f"script {self.text!r:.200}: a number is too large") from None
        return value


def parse(text: str) -> Script:
    """Return a parsed script.

    Raises:
        ScriptError: The script is invalid; the text names the position and the expected token.
    """
    return _Parser(text).script()


class _Token(NamedTuple):
    kind: str
    text: str
    position: int


class _Parser:
    """A recursive-descent parser with one method for each precedence level of BehaviorTree.CPP."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = list(self._read())
        self._index = 0
        self._depth = 0
        self._names: dict[str, None] = {}
        self._changed: dict[str, None] = {}

    def script(self) -> Script:
        statements = []
        while True:
            while self._take(";"):
                pass
            if self._next.kind == "end":
                break
            statements.append(self._expression().evaluate)
            if self._next.kind != "end" and self._next.text != ";":
                self._fail("an operator or ';'")
        if not statements:
            self._fail("a statement")
        return Script(self._text, tuple(self._names), tuple(self._changed), tuple(statements))

    def _read(self) -> Iterator[_Token]:
        position = 0
        while position < len(self._text):
            if self._text[position].isspace():
                position += 1
                continue
            found = _TOKEN.match(self._text, position)
            if found is None:
                raise self._error(position, "a number, a name, a text in quotes or an operator", self._text[position:])
            yield _Token(found.lastgroup or "", found.group(), position)
            position = found.end()
        yield _Token("end", "", position)

    def _expression(self) -> Term:
        target = self._conditional()
        sign = self._take(*_ASSIGNMENTS)
        if not sign:
            return target
        if not target.name:
            self._fail(f"the name of an entry before {sign!r}", back=1)
        self._changed[target.name] = None
        value = self._conditional()
        return self._made(assignment(target.name, sign, value), value)

    def _conditional(self) -> Term:
        condition = self._logical()
        if not self._take("?"):
            return condition
        one = self._nested()
        self._need(":")
        other = self._logical()
        return self._made(choice(condition, one, other), condition, one, other)

    def _logical(self) -> Term:
        left = self._comparison()
        while sign := self._take("&&", "||"):
            right = self._comparison()
            left = self._made(binary(sign, left, right), left, right)
        return left

    def _comparison(self) -> Term:
        operands, signs = [self._arithmetic()], []
        while sign := self._take(*_COMPARISONS):
            signs.append(sign)
            operands.append(self._arithmetic())
        return self._made(comparison(signs, operands), *operands) if signs else operands[0]

    def _arithmetic(self, least: int = 1) -> Term:
        left = self._operand()
        while True:
            binding, kind = _ARITHMETIC.get(self._next.text, (0, ""))
            if self._next.kind != "sign" or binding < least:
                return left
            sign = self._take(self._next.text)
            right = self._arithmetic(binding + 1)
            left = self._made(binary(sign, left, right), left, right, kind=kind)

    def _operand(self) -> Term:
        sign = self._take("-", "+", "~", "!")
        if sign in ("-", "+") and self._next.kind == "number":
            value = self._number(self._advance())
            return literal(-value if sign == "-" else value)
        if sign == "+":
            self._fail("a number")
        if sign:
            self._deeper()
            operand = self._operand()
            self._depth -= 1
            return self._made(unary(sign, operand), operand, kind="arithmetic" if sign == "-" else "bitwise")
        return self._atom()

    def _atom(self) -> Term:
        if self._take("("):
            nested = self._nested()
            self._need(")")
            return nested._replace(kind="", name="")
        token = self._next
        if token.kind not in ("number", "name", "text"):
            self._fail("a value")
        self._advance()
        if token.kind == "number":
            return literal(self._number(token))
        if token.kind == "text":
            return literal(token.text[1:-1])
        if token.text in ("true", "false"):
            return literal(token.text == "true")
        self._names[token.text] = None
        return Term(lookup(token.text), name=token.text)

    def _number(self, token: _Token) -> float:
        text = token.text
        if not text.isdigit() and text[:2].lower() != "0x":
            return float(text)
        digits, base = (text[2:], 16) if text[:2].lower() == "0x" else (text, 10)
        if len(digits.lstrip("0")) >= len(str(_MAX_NUMBER)) + 1 or int(digits, base) >= _MAX_NUMBER:
            raise self._error(token.position, "a number of 64 bits", text)
        return int(digits, base)

    def _nested(self) -> Term:
        self._deeper()
        nested = self._expression()
        self._depth -= 1
        return nested

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            self._fail(f"something simpler (at most {_MAX_DEPTH} parentheses within each other)")

    def _made(self, evaluate: Callable[[Environment], Any], *parts: Term, kind: str = "") -> Term:
        depth = 1 + max(part.depth for part in parts)
        if depth > _MAX_OPERATORS:
            self._fail(f"something shorter (at most {_MAX_OPERATORS} operators in a row)")
        if kind and any(part.kind not in ("", kind) for part in parts):
            self._fail("parentheses where arithmetic and bitwise operators or '!' meet", back=1)
        return Term(evaluate, depth, kind)

    @property
    def _next(self) -> _Token:
        return self._tokens[self._index]

    def _advance(self) -> _Token:
        self._index += 1
        return self._tokens[self._index - 1]

    def _take(self, *signs: str) -> str:
        """Consume and return the next sign if it is one of these; else return an empty string."""
        if self._next.kind == "sign" and self._next.text in signs:
            return self._advance().text
        return ""

    def _need(self, sign: str) -> None:
        if not self._take(sign):
            self._fail(repr(sign))

    def _fail(self, expected: str, back: int = 0) -> NoReturn:
        token = self._tokens[self._index - back]
        raise self._error(token.position, expected, token.text)

    def _error(self, position: int, expected: str, got: str) -> ScriptError:
        found = f"got {got!r:.40}" if got else "got its end"
        return ScriptError(f"script {self._text!r:.200}: character {position + 1}: expected {expected}, {found}")
