"""How commands end."""

from __future__ import annotations

from typing import Final

DONE: Final = 0
FAILED: Final = 1
WRONG_USE: Final = 2
NOBODY: Final = 3

EXIT_CODES: Final = """\
exit codes:
  0 done; 1 a tree failed, or there is no such robot or action; 2 wrong use, no such tree, or the name of
  the participant is taken; 3 no simulator answers; 130 Ctrl-C, 143 SIGTERM: the goals are canceled (a second
  one does not wait for that)"""
