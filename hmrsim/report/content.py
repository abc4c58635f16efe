"""The content of a trace's section or of a recording, from which a report is made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from hmrsim.report.wording import times

if TYPE_CHECKING:
    from hmrsim.report.model import Source
    from hmrsim.report.story import Story


class ReportInput(NamedTuple):
    """The content of a section of a trace, or of a recording.

    Attributes:
        source: The kind and the quality of the source.
        header: The section's first line, or a recording's world information.
        definition: The world, as in a native file.
    """

    story: Story
    source: Source
    header: Mapping[str, Any]
    definition: Mapping[str, Any]

    @property
    def section(self) -> int:
        """The number of the section, from 1."""
        number = self.header.get("section", 1)
        return number if isinstance(number, int) else 1

    @property
    def cause(self) -> str:
        """Why the section began; empty for the first one."""
        cause = self.header.get("cause", "")
        return cause if isinstance(cause, str) else ""


def notes_of(story: Story) -> Iterator[str]:
    """Yield what should be noted of how a story was read."""
    if story.misfits:
        first = f"first {story.first_misfit}"
        yield f"{story.misfits} events are ignored, as this version can't read them ({first})."
    if story.restarts:
        yield f"Simulated time was reset ({times(story.restarts)}); here it continues."
