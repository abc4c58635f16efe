"""A simulation in lockstep that requests of participants advance, without a wire."""

from __future__ import annotations

import math

from hmrsim.protocol.commands import Advance
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.time import Join, Leave
from tests.simulation import in_lockstep

RESULT = frozenset({"result"})


class Steps:
    """A simulation in lockstep, with the answers to its participants by request."""

    def __init__(self, *, topics=frozenset(), most=16, **settings):
        self.run, self.lockstep = in_lockstep(topics=topics, **settings)
        self.simulator = self.run.simulator
        self._most = most
        self._asked = 0

    def join(self, *names):
        """Join participants; return the answer to the last one."""
        for name in names:
            answer = self._ask(lambda reply_to, name=name: self.lockstep.join(Join(name, reply_to), 0.0))
        return self.answers(answer)

    def ask(self, name, epoch, until=math.inf, *commands, wake=RESULT, report=frozenset()):
        """Request an advance; return its number, for `answers`."""
        advance = Advance(name, epoch, until, frozenset(wake), frozenset(report), commands)
        return self._ask(lambda reply_to: self.lockstep.advance(advance._replace(reply_to=reply_to), 0.0))

    def advance(self, *args, **kwargs):
        """Request an advance, grant time, and return the answer."""
        asked = self.ask(*args, **kwargs)
        self.move()
        return self.answers(asked)

    def leave(self, name):
        """Remove a participant; return the answer."""
        return self.answers(self._ask(lambda reply_to: self.lockstep.leave(Leave(name, reply_to))))

    def move(self):
        """Grant time until no more can be granted."""
        while self.lockstep.ready:
            self.lockstep.begin()
            while self.lockstep.proceed(self._most, 0.0):
                pass

    def answers(self, asked):
        """Return the answer to a request; None while it is pending."""
        found = self.run.log.answers(asked)
        assert len(found) <= 1
        return found[0] if found else None

    def happened(self):
        """Return kind and participant of the published events of participants."""
        events = [event for _, event in self.run.log.events if isinstance(event, EventStamped)]
        return [(each.kind, each.fields["participant"]) for each in events if each.kind.startswith("participant")]

    def _ask(self, ask):
        self._asked += 1
        ask(self._asked)
        return self._asked
