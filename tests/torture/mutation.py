"""Random changes of files: their bytes, lines, words, or values."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any, Final

import yaml

if TYPE_CHECKING:
    from random import Random

_NUMBERS: Final = (
    *("0", "-1", "1", "1e308", "-1e308", "5e-324", "1e-300", "1e16", "3e9", "4294967296", "9223372036854775808"),
    *("1" + "0" * 400, "NaN", ".nan", "Infinity", "-.inf", "0x7fffffff", "1_000", "00", "1e999", "2026-01-01", "0.1"),
)
_TEXTS: Final = (
    *("", "null", "~", "true", "[]", "{}", '""', "x" * 5_000, "x" * 300_000, "\x1b[2J", "\x00", "\u202e", "💥"),
    *("../../etc/passwd", "/dev/zero", "**", "a/b", "%s", "*a", "&a", "<<", "!!python/object:os.system", "- " * 500),
    *(
        "&#x1b;",
        "&amp;",
        "<a>" * 300,
        "]]>",
        "<!DOCTYPE x [<!ENTITY a 'b'>]>",
        "--",
        "\ufeff",
        "\r",
        "\u2028",
        "'",
        '"',
    ),
)
_VALUES: Final[tuple[Any, ...]] = (
    *(None, True, False, 0, -1, 1, 2**31, 2**53, 2**64, -(2**63), 10**400, 1e308, -1e308, 5e-324, 1e-9, 1e16),
    *("", "x", "x" * 5_000, "\x00", "\x1b[2J", [], {}, [[]], {"a": 1}, [0, 0], [1e308, -1e308], ["a"] * 1_000),
)
_MAX_DEPTH: Final = 2_000
_MAX_BYTES: Final = 2_000_000
_MAX_VALUES: Final = 100_000
_DEEP: Final = (*('{"a":', "[", "{a: ", "<Sequence>", "<root>", "- "), *("&a [*a, ", "(", '<mxCell id="x">', "  "))
_WORD: Final = re.compile(rb"[\w.+-]+")
_NUMBER: Final = re.compile(rb"-?\d+(?:\.\d+)?")


def mutated(content: bytes, random: Random, other: bytes) -> bytes:
    """Return a file with a few changes, some of them parts of *other*, a file of the same kind."""
    if random.random() < 0.4 and (data := _parsed(content)) is not None:
        for _ in range(random.choice((1, 1, 1, 2, 5))):
            data = with_other_value(data, random)
        return _written(data, random)
    for _ in range(random.choice((1, 1, 1, 2, 3, 8))):
        content = random.choice(_CHANGES)(content, random, other)[:_MAX_BYTES]
    return content


def mutated_lines(lines: list[bytes], random: Random, other: bytes) -> bytes:
    """Return a file of JSON, a value a line, with changes within a few lines."""
    lines = list(lines)
    for _ in range(random.choice((1, 1, 2, 5))):
        i = random.randrange(len(lines))
        lines[i] = mutated(lines[i].rstrip(b"\n"), random, other[:2_000]).replace(b"\n", b" ") + b"\n"
    return b"".join(lines)


def _parsed(content: bytes) -> Any:
    try:
        text = content.decode()
        return json.loads(text) if text.lstrip()[:1] in "{[" else yaml.load(text, yaml.CSafeLoader)
    except (ValueError, yaml.YAMLError, RecursionError):
        return None


def _written(data: Any, random: Random) -> bytes:
    if random.random() < 0.3:
        try:
            return yaml.dump(data, Dumper=yaml.CSafeDumper, allow_unicode=True).encode()
        except yaml.YAMLError:
            pass
    return json.dumps(data, ensure_ascii=random.random() < 0.5).encode()


def with_other_value(data: Any, random: Random) -> Any:
    """Return values with one change, at any depth."""
    inner = list(data) if isinstance(data, dict) else list(range(len(data))) if isinstance(data, list) else []
    if not inner or random.random() < 0.05:
        return random.choice(_VALUES)
    copy = dict(data) if isinstance(data, dict) else list(data)
    where = random.choice(inner)
    what = random.random()
    if what < 0.75:
        copy[where] = with_other_value(copy[where], random)
    elif what < 0.85:
        del copy[where]
    elif what < 0.95:
        copy[where] = copy[random.choice(inner)]
    elif isinstance(copy, dict):
        copy[random.choice(("", "x", "type", "at", "name", "include", "lanes"))] = random.choice(_VALUES)
    else:
        more = copy * random.choice((1, 10, 1_000))
        # Lists of lists that grow several times would not fit into memory.
        copy += more if _has_at_most(_MAX_VALUES, more) else []
    return copy


def _has_at_most(most: int, data: Any) -> bool:
    """Return whether there are at most so many values in some, at any depth."""
    ahead, seen = [data], 0
    while ahead and seen <= most:
        one = ahead.pop()
        seen += 1
        if len(ahead) + seen <= most and isinstance(one, dict | list):
            ahead += one.values() if isinstance(one, dict) else one
    return seen + len(ahead) <= most


def _span(content: bytes, random: Random, longest: int = 64) -> tuple[int, int]:
    begin = random.randrange(len(content) + 1)
    return begin, min(len(content), begin + random.randrange(longest))


def _flip(content: bytes, random: Random, _other: bytes) -> bytes:
    if not content:
        return b"\xff"
    i = random.randrange(len(content))
    return content[:i] + bytes([content[i] ^ (1 << random.randrange(8))]) + content[i + 1 :]


def _random_bytes(content: bytes, random: Random, _other: bytes) -> bytes:
    begin, end = _span(content, random)
    return content[:begin] + random.randbytes(random.choice((1, 4, 8, 30))) + content[end:]


def _delete(content: bytes, random: Random, _other: bytes) -> bytes:
    begin, end = _span(content, random, random.choice((8, 64, 4_000)))
    return content[:begin] + content[end:]


def _double(content: bytes, random: Random, _other: bytes) -> bytes:
    begin, end = _span(content, random, random.choice((8, 64, 4_000)))
    return content[:end] + content[begin:end] * random.choice((1, 1, 3, 200)) + content[end:]


def _cut(content: bytes, random: Random, _other: bytes) -> bytes:
    return content[: random.randrange(len(content) + 1)]


def _lines(content: bytes, random: Random, other: bytes) -> bytes:
    """Swap, repeat or drop lines, or take one from another file."""
    lines = content.splitlines(keepends=True) or [b""]
    i, j = random.randrange(len(lines)), random.randrange(len(lines))
    what = random.randrange(4)
    if what == 0:
        lines[i], lines[j] = lines[j], lines[i]
    elif what == 1:
        lines.insert(j, lines[i])
    elif what == 2:
        del lines[i]
    else:
        lines.insert(i, random.choice(other.splitlines(keepends=True) or [b""]))
    return b"".join(lines)


def _replace(pattern: re.Pattern[bytes], content: bytes, random: Random, new: bytes) -> bytes:
    begin = random.randrange(len(content) + 1)
    found = pattern.search(content, begin) or pattern.search(content)
    return content if found is None else content[: found.start()] + new + content[found.end() :]


def _number(content: bytes, random: Random, _other: bytes) -> bytes:
    return _replace(_NUMBER, content, random, random.choice(_NUMBERS).encode())


def _text(content: bytes, random: Random, _other: bytes) -> bytes:
    return _replace(_WORD, content, random, random.choice(_TEXTS).encode())


def _word(content: bytes, random: Random, other: bytes) -> bytes:
    """Replace a word by another one of this or the other file."""
    words = _WORD.findall(random.choice((content, other))[:100_000]) or [b"x"]
    return _replace(_WORD, content, random, random.choice(words))


def _deep(content: bytes, random: Random, _other: bytes) -> bytes:
    begin, _ = _span(content, random)
    return content[:begin] + random.choice(_DEEP).encode() * random.choice((5, 100, _MAX_DEPTH)) + content[begin:]


_CHANGES: Final = (
    _flip,
    _flip,
    _random_bytes,
    _delete,
    _double,
    _cut,
    _lines,
    _lines,
    _number,
    _number,
    _text,
    _word,
    _word,
    _deep,
)
