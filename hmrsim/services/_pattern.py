"""POSIX extended regular expressions, matched in bounded time: Python's own can take years over a short one.

A pattern is a function from places in a text to the places where a match that begins there may end. What it may
cost is counted, so that whoever sends a pattern can't stop the simulation.
"""

from __future__ import annotations

import string
from collections.abc import Callable
from functools import partial, reduce
from typing import Final

_LONGEST: Final = 256
_MOST_REPEATS: Final = 255
_MOST_PLACES: Final = 200_000

_CLASSES: Final = {
    "alnum": string.ascii_letters + string.digits,
    "alpha": string.ascii_letters,
    "blank": " \t",
    "digit": string.digits,
    "lower": string.ascii_lowercase,
    "punct": string.punctuation,
    "space": string.whitespace,
    "upper": string.ascii_uppercase,
    "xdigit": string.hexdigits,
}
_SPECIAL: Final = frozenset("|()*+?{")

Places = frozenset[int]
Node = Callable[["_Match", Places], Places]


class PatternError(ValueError):
    """A pattern makes no sense, or takes too long."""


class _Match:
    """One text, and how much may still be spent on it."""

    def __init__(self, text: str) -> None:
        self.text = text
        self._left = _MOST_PLACES

    def spend(self, places: Places) -> Places:
        self._left -= 1 + len(places)
        if self._left < 0:
            raise PatternError("it takes too long; use fewer repetitions inside each other")
        return places


def compiled(pattern: str) -> Callable[[str], bool]:
    """Return what tells whether a text has a match of the pattern anywhere in it.

    Raises:
        PatternError: It is no pattern; the function raises it, too, when a match takes too long.
    """
    if len(pattern) > _LONGEST:
        raise PatternError(f"it has {len(pattern)} characters; at most {_LONGEST} are taken")
    parser = _Parser(pattern)
    node = parser.alternatives()
    if parser.rest:
        raise PatternError(f"')' at {parser.at + 1} closes nothing")

    def search(text: str) -> bool:
        return bool(node(_Match(text), frozenset(range(len(text) + 1))))

    return search


class _Parser:
    """Reads a pattern from left to right."""

    def __init__(self, pattern: str) -> None:
        self._pattern = pattern
        self.at = 0

    @property
    def rest(self) -> str:
        """What has not been read."""
        return self._pattern[self.at :]

    def _take(self, expected: str) -> bool:
        found = self.rest.startswith(expected)
        self.at += len(expected) if found else 0
        return found

    def _next(self) -> str:
        if not self.rest:
            raise PatternError("it ends too early")
        self.at += 1
        return self._pattern[self.at - 1]

    def alternatives(self) -> Node:
        """Read what stands between bars."""
        found = [self._sequence()]
        while self._take("|"):
            found.append(self._sequence())
        return found[0] if len(found) == 1 else partial(_any, tuple(found))

    def _sequence(self) -> Node:
        found: list[Node] = []
        while self.rest and self.rest[0] not in "|)":
            found.append(self._repeated(self._one()))
        return partial(_all, tuple(found))

    def _one(self) -> Node:
        character = self._next()
        if character == "(":
            node = self.alternatives()
            if not self._take(")"):
                raise PatternError("a ')' is missing")
            return node
        if character in _SPECIAL:
            raise PatternError(f"nothing stands before {character!r} at {self.at}, that it could repeat")
        if character in "^$":
            return _begin if character == "^" else _end
        if character == ".":
            return partial(_character, None)
        if character == "[":
            return self._bracket()
        return partial(_character, frozenset(self._next() if character == "\\" else character))

    def _repeated(self, node: Node) -> Node:
        while self.rest and self.rest[0] in "*+?{":
            least, most = self._bounds(self._next())
            node = partial(_repeat, node, least, most)
        return node

    def _bounds(self, sign: str) -> tuple[int, int | None]:
        if sign != "{":
            return {"*": (0, None), "+": (1, None), "?": (0, 1)}[sign]
        text, brace, _ = self.rest.partition("}")
        first, comma, second = text.partition(",")
        numbers = [number for number in (first, second) if number]
        if not brace or not first or not all(number.isascii() and number.isdigit() for number in numbers):
            raise PatternError("expected {N}, {N,} or {N,M} after '{'")
        self.at += len(text) + 1
        least = int(first)
        most = least if not comma else int(second) if second else None
        if max(map(int, numbers)) > _MOST_REPEATS or (most is not None and most < least):
            raise PatternError(f"{{{text}}} must be in order, and at most {_MOST_REPEATS}")
        return least, most

    def _bracket(self) -> Node:
        """Read a set of characters, after its opening bracket."""
        negated = self._take("^")
        found: set[str] = set()
        first = True
        while first or not self._take("]"):
            first = False
            if self._take("[:"):
                name, end, _ = self.rest.partition(":]")
                if not end or name not in _CLASSES:
                    raise PatternError(f"no class of characters {name[:20]!r}; there are: {', '.join(_CLASSES)}")
                self.at += len(name) + len(end)
                found.update(_CLASSES[name])
                continue
            low = high = self._next()
            if self.rest.startswith("-") and not self.rest.startswith("-]"):
                self.at += 1
                high = self._next()
            if high < low or ord(high) - ord(low) > _MOST_PLACES:
                raise PatternError(f"range {low}-{high} is not in order")
            found.update(map(chr, range(ord(low), ord(high) + 1)))
        return partial(_not if negated else _character, frozenset(found))


def _character(wanted: frozenset[str] | None, match: _Match, places: Places) -> Places:
    text = match.text
    ends = (at + 1 for at in places if at < len(text) and (wanted is None or text[at] in wanted))
    return match.spend(frozenset(ends))


def _not(unwanted: frozenset[str], match: _Match, places: Places) -> Places:
    text = match.text
    return match.spend(frozenset(at + 1 for at in places if at < len(text) and text[at] not in unwanted))


def _begin(_match: _Match, places: Places) -> Places:
    return places & {0}


def _end(match: _Match, places: Places) -> Places:
    return places & {len(match.text)}


def _all(nodes: tuple[Node, ...], match: _Match, places: Places) -> Places:
    return reduce(lambda reached, node: node(match, reached) if reached else reached, nodes, places)


def _any(nodes: tuple[Node, ...], match: _Match, places: Places) -> Places:
    return frozenset().union(*(node(match, places) for node in nodes))


def _repeat(node: Node, least: int, most: int | None, match: _Match, places: Places) -> Places:
    for _ in range(least):
        places = match.spend(node(match, places))
    reached, new, times = places, places, least
    while new and (most is None or times < most):
        new = match.spend(node(match, new)) - reached
        reached |= new
        times += 1
    return reached
