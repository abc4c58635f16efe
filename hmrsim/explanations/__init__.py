"""What codes mean, why they come, and what to do about them: the texts of ``hmrsim explain`` and of a page each.

Codes are those of results (Nav2's and MoveIt's), the reasons of rejections, the causes of goals that did not succeed,
and the exit codes of commands.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

import yaml

if TYPE_CHECKING:
    from collections.abc import Mapping

_FILE: Final = Path(__file__).with_name("codes.yaml")


@dataclass(frozen=True)
class Explanation:
    """What is known of a code.

    Attributes:
        code: The code, as a text.
        name: Its name in Nav2 or MoveIt, or what kind of code it is.
        of: The actions that have it.
        means: What it means, a sentence.
        why: Why it comes, in Markdown: paragraphs and lists, each paragraph or entry on one line.
        do: What to do, likewise.
    """

    code: str
    name: str
    of: str
    means: str
    why: str
    do: str


@cache
def explanations() -> Mapping[str, Explanation]:
    """Return all explanations by their codes, numbers first."""
    said = yaml.safe_load(_FILE.read_text(encoding="utf-8"))
    return {str(each["code"]): Explanation(**{**each, "code": str(each["code"])}) for each in said}
