"""POSIX extended regular expressions in time linear in the text, whatever a client sends.

The syntax is that of RE2's POSIX mode: as POSIX, but a backslash escapes between brackets, too; there are neither
collating elements (``[.x.]``, ``[=x=]``) nor repetitions of more than 1000.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

_MAX_CHARACTERS: Final = 256
_MAX_BYTES: Final = 256 * 1024
"""Of memory for a compiled pattern and its search; limits the time for both, too."""


class PatternError(ValueError):
    """A pattern is invalid, or too large."""


def compiled(pattern: str) -> Callable[[str], bool]:
    """Return a function that tells whether a text contains a match of the pattern.

    Raises:
        PatternError: It is not a pattern, or too large.
    """
    if not pattern:
        return lambda _text: True
    if len(pattern) > _MAX_CHARACTERS:
        raise PatternError(f"it has {len(pattern)} characters; at most {_MAX_CHARACTERS} are taken")
    # Loading the library takes 15 ms, and few simulations filter entities by name.
    import re2  # noqa: PLC0415

    options = re2.Options()
    options.posix_syntax = options.one_line = options.dot_nl = options.never_capture = True
    options.log_errors = False
    options.max_mem = _MAX_BYTES
    try:
        expression = re2.compile(pattern, options)
    except re2.error as error:
        raise PatternError(error.args[0].decode()) from None
    except UnicodeEncodeError:
        raise PatternError("it has half of a surrogate pair") from None
    return lambda text: expression.search(text) is not None
