"""Linear temporal logic by its definition, on words that end in one letter forever; to compare patterns with.

A word is a list of letters, each a set of propositions; after it comes its last letter forever. A formula is a
function of a word and a position.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

Word = Sequence[frozenset[str]]
Formula = Callable[[Word, int], bool]


def is_(name: str) -> Formula:
    """Return that a proposition is in the letter."""
    return lambda word, i: name in word[min(i, len(word) - 1)]


def not_(part: Formula) -> Formula:
    """Return that a formula does not hold."""
    return lambda word, i: not part(word, i)


def and_(*parts: Formula) -> Formula:
    """Return that all hold."""
    return lambda word, i: all(part(word, i) for part in parts)


def implies(left: Formula, right: Formula) -> Formula:
    """Return that if one holds, another one does."""
    return lambda word, i: not left(word, i) or right(word, i)


def same(left: Formula, right: Formula) -> Formula:
    """Return that both hold, or none."""
    return lambda word, i: left(word, i) == right(word, i)


def next_(part: Formula) -> Formula:
    """Return that it holds at the next position."""
    return lambda word, i: part(word, min(i + 1, len(word) - 1))


def eventually(part: Formula) -> Formula:
    """Return that it holds somewhere from here on."""
    return lambda word, i: any(part(word, j) for j in range(i, len(word)))


def always(part: Formula) -> Formula:
    """Return that it holds everywhere from here on."""
    return lambda word, i: all(part(word, j) for j in range(i, len(word)))


def until(left: Formula, right: Formula) -> Formula:
    """Return that the right one holds somewhere, and the left one up to there."""
    return lambda word, i: any(right(word, j) and all(left(word, k) for k in range(i, j)) for j in range(i, len(word)))


def weak_until(left: Formula, right: Formula) -> Formula:
    """Return the same, or that the left one holds forever."""
    return lambda word, i: until(left, right)(word, i) or always(left)(word, i)


# The templates of the patterns, as http://roboticpatterns.com has them.


def visit(places: Sequence[str]) -> Formula:
    """Return the conjunction of F l_i for all i."""
    return and_(*(eventually(is_(place)) for place in places))


def sequenced_visit(places: Sequence[str]) -> Formula:
    """F (l1 and F (l2 and ... F (ln)))."""
    first, *rest = places
    return eventually(and_(is_(first), sequenced_visit(rest)) if rest else is_(first))


def _in_order(places: Sequence[str]) -> list[Formula]:
    return [until(not_(is_(b)), is_(a)) for a, b in pairwise(places)]


def ordered_visit(places: Sequence[str]) -> Formula:
    """The sequenced visit, and (not l_(i+1)) U l_i."""
    return and_(sequenced_visit(places), *_in_order(places))


def strict_ordered_visit(places: Sequence[str]) -> Formula:
    """The ordered visit, and (not l_i) U (l_i and X ((not l_i) U l_(i+1)))."""
    strict = [until(not_(is_(a)), and_(is_(a), next_(until(not_(is_(a)), is_(b))))) for a, b in pairwise(places)]
    return and_(ordered_visit(places), *strict)


def _fair(places: Sequence[str]) -> list[Formula]:
    return [
        always(implies(is_(a), next_(weak_until(not_(is_(a)), is_(places[(i + 1) % len(places)])))))
        for i, a in enumerate(places)
    ]


def fair_visit(places: Sequence[str]) -> Formula:
    """The visit, and G (l_i -> X ((not l_i) W l_(i+1)))."""
    return and_(visit(places), *_fair(places))


def fair_patrol(places: Sequence[str]) -> Formula:
    """G (l_i -> X ((not l_i) W l_(i+1))): the condition of fair patrolling on the order."""
    return and_(*_fair(places))


def ordered_patrol(places: Sequence[str]) -> Formula:
    """(not l_(i+1)) U l_i and G (l_(i+1) -> X ((not l_(i+1)) U l_i)), with weak untils, as a patrol goes on."""
    pairs = [(a, places[(i + 1) % len(places)]) for i, a in enumerate(places)]
    return and_(
        *(weak_until(not_(is_(b)), is_(a)) for a, b in pairs[:-1]),
        *(always(implies(is_(b), next_(weak_until(not_(is_(b)), is_(a))))) for a, b in pairs),
    )


def strict_ordered_patrol(places: Sequence[str]) -> Formula:
    """The same, and G (l_i -> X ((not l_i) U l_(i+1))) but for the last one."""
    strict = [always(implies(is_(a), next_(weak_until(not_(is_(a)), is_(b))))) for a, b in pairwise(places)]
    return and_(ordered_patrol(places), *strict)


def at_least(name: str, count: int) -> Formula:
    """F (l1 and X F (l1 and ...)), the given number of times."""
    return eventually(and_(is_(name), next_(at_least(name, count - 1))) if count > 1 else is_(name))


def exactly(name: str, count: int) -> Formula:
    """(not l1) U (l1 and X ((not l1) U (l1 ... and X G not l1)))."""
    rest = always(not_(is_(name))) if count == 1 else exactly(name, count - 1)
    return until(not_(is_(name)), and_(is_(name), next_(rest)))
