"""If the controller reports an outcome, a condition holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.simulation import RunReported
from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.operators.settling import Settling
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Ended, Tell, Verdict


class Reporting(Settling):
    """A condition holds whenever the controller reports an outcome: as it ends, or by `end_run`.

    Args:
        report: The outcome: how the controller ends, or the label that it gives to `end_run`.
        words: The condition in words that are the same for each robot.
    """

    def __init__(
        self,
        name: str,
        subject: str,
        report: str,
        condition: BaseModel,
        words: str,
        observations: Observations,
        tell: Tell,
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self._report, self._words, self._said = report, words, describe(condition)
        self._term = self.term(condition)
        self._reports = self._judged = 0
        self._known = False
        self.timeline.on(RunReported, self._hear)

    def _hear(self, _at: int, event: RunReported) -> None:
        if event.label == self._report:
            self._reports += 1
            self.mark()

    def settled(self, at: int) -> None:
        """Look at the condition, and judge the reports of this instant."""
        self._term.look()
        if self._reports > self._judged:
            self._judged = self._reports
            self._judge(at)

    def end(self, at: int, ended: Ended | None) -> None:
        """Judge the end of the controller, which is its report as well."""
        self._known = ended is not None and not cut_off(ended)
        if ended is not None and ended.ending == self._report:
            self._reports += 1
            self._judge(at)

    def _judge(self, at: int) -> None:
        if not self._term.holds:
            reason = f"reported {self._report}, but not: {self._words}"
            text = f"the controller reports {self._report}, but it is not so that {self._said}"
            self.violate(at, self.subject, reason, text)

    def unless_violated(self) -> Verdict:
        """Return whether it has reported that, and the condition held each time."""
        if self._reports:
            return self._is("holds", 1.0, f"the controller reported {self._report}, and {self._said}")
        if not self._known:
            return self._is("undecided", 0.0, f"it is not known whether the controller ends as {self._report}")
        return self._is("never_exercised", 1.0, f"the controller never reported {self._report}")
