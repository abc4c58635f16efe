"""Zenoh's access control: the permissions of certificates on keys, and the rules that grant them.

The simulator's session enforces a policy. Everybody else reads it to explain a denial, or to filter in advance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import zenoh

from hmrsim.diagnostics import shown

Flow = Literal["ingress", "egress"]
"""The direction of a message, as the session that enforces the policy sees it."""

Message = Literal[
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "declare_queryable",
    "reply",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
]
"""The kinds of messages that a policy is about."""

MESSAGES: Final[tuple[Message, ...]] = get_args(Message)

FLOWS: Final[tuple[Flow, ...]] = get_args(Flow)

EVERYTHING: Final = ("**", "**/@adv/**", "**/@simulator/**", "@ros2_lv/**")
"""All keys; wildcards do not match chunks that begin with ``@``."""


READING: Final = "all read values"
"""The rule about what all members, and visitors of a page, may query."""


@dataclass(frozen=True)
class Rule:
    """Allows or denies some messages on some keys; a denial takes precedence over permissions.

    Attributes:
        id: Its name, which explanations show.
        flow: From the client (``ingress``) or to the client (``egress``).
        keys: Key expressions. A rule is about a message if one of them includes the message's key expression.
        deny: Whether it denies.
    """

    id: str
    messages: tuple[Message, ...]
    flow: Flow
    keys: tuple[str, ...]
    deny: bool = False

    def covers(self, message: Message, flow: Flow, key: str) -> bool:
        """Return whether the rule is about a message."""
        asked = zenoh.KeyExpr(key)
        return (
            flow == self.flow
            and message in self.messages
            and any(zenoh.KeyExpr(mine).includes(asked) for mine in self.keys)
        )

    def to_json(self) -> dict[str, Any]:
        """Return the rule in Zenoh's form."""
        return {
            "id": self.id,
            "permission": "deny" if self.deny else "allow",
            "flows": [self.flow],
            "messages": list(self.messages),
            "key_exprs": list(self.keys),
        }


@dataclass(frozen=True)
class Decision:
    """The decision of a policy about a message.

    Attributes:
        rule: The rule that allows or denies the message; empty if no rule applies, so that it is denied.
    """

    allowed: bool
    rule: str = ""

    def __str__(self) -> str:
        """Return the decision as text."""
        if self.rule:
            return f"{'allowed' if self.allowed else 'denied'} by rule {self.rule!r}"
        return "denied, as no rule allows it"


@dataclass(frozen=True)
class AccessControl:
    """A policy: rules for each certificate's common name. Messages that no rule allows are denied."""

    rules: Mapping[str, tuple[Rule, ...]]

    def decide(self, name: str, message: Message, flow: Flow, key: str) -> Decision:
        """Return whether a client may send (``ingress``), or is sent (``egress``), a message on a key expression."""
        about = [rule for rule in self.rules.get(name, ()) if rule.covers(message, flow, key)]
        if not about:
            return Decision(allowed=False)
        first = next((rule for rule in about if rule.deny), about[0])
        return Decision(not first.deny, first.id)

    def may_query(self, name: str, key: str) -> Decision:
        """Return whether a client may query a key: get a value, send a goal, call a service.

        Without a name, as visitors of a page are without a certificate, only what all members read.
        """
        return self.decide(name, "query", "ingress", key) if name else self.reads(key)

    def denial(self, name: str, key: str) -> str:
        """Return why a client may not query a key, and who may; empty if it may."""
        decision = self.may_query(name, key)
        if decision.allowed:
            return ""
        who = repr(name) if name else "a visitor without a certificate"
        others = ", ".join(self.who_may_query(key)) or "no one"
        return f"{who} may not ask on {key!r}: {decision}; who may: {others}"

    def reads(self, key: str) -> Decision:
        """Return whether a query is one of those that only read, for visitors without a name."""
        rules = {rule for each in self.rules.values() for rule in each if rule.id == READING}
        allowed = any(rule.covers("query", "ingress", key) for rule in rules)
        return Decision(allowed, READING if allowed else "")

    def who_may_query(self, key: str) -> list[str]:
        """Return the names that may query a key."""
        return [name for name in self.rules if self.may_query(name, key).allowed]

    def to_json(self) -> dict[str, Any]:
        """Return the policy in Zenoh's form, each rule once."""
        every = {rule.id: rule for rules in self.rules.values() for rule in rules}
        named = {name: rules for name, rules in self.rules.items() if rules}
        return {
            "enabled": True,
            "default_permission": "deny",
            "rules": [rule.to_json() for rule in every.values()],
            "subjects": [{"id": name, "cert_common_names": [name]} for name in named],
            "policies": [
                {"id": name, "subjects": [name], "rules": [rule.id for rule in rules]} for name, rules in named.items()
            ],
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> AccessControl:
        """Return the policy of an ``access_control`` in Zenoh's form.

        Raises:
            ValueError: It has another form.
        """
        try:
            rules = {rule["id"]: tuple(_rules(rule)) for rule in data["rules"]}
            names = {subject["id"]: list(map(str, subject["cert_common_names"])) for subject in data["subjects"]}
            found: dict[str, list[Rule]] = {}
            for policy in data["policies"]:
                for name in (name for subject in policy["subjects"] for name in names[subject]):
                    found.setdefault(name, []).extend(each for rule in policy["rules"] for each in rules[rule])
            return cls({name: tuple(each) for name, each in found.items()})
        except (KeyError, TypeError, AttributeError, zenoh.ZError) as error:
            raise ValueError(f"not an access control of Zenoh: {type(error).__name__}: {error}") from None


def _rules(data: Mapping[str, Any]) -> Iterable[Rule]:
    keys = tuple(str(zenoh.KeyExpr(key)) for key in data["key_exprs"])
    messages, flows = tuple(data["messages"]), tuple(data["flows"])
    for given, known in ((messages, MESSAGES), (flows, FLOWS), ((data["permission"],), ("allow", "deny"))):
        if unknown := [each for each in given if each not in known]:
            raise ValueError(f"no {shown(unknown[0])}; there are {', '.join(known)}")
    return [Rule(str(data["id"]), messages, flow, keys, data["permission"] == "deny") for flow in flows]


def trusting(names: Sequence[str]) -> AccessControl:
    """Return the policy of a client: it speaks with these certificates only.

    Else the certificate of any other client, which the same authority has signed, could pose as the simulator.
    """
    rules = (
        Rule("from the simulator", MESSAGES, "ingress", EVERYTHING),
        Rule("to the simulator", MESSAGES, "egress", EVERYTHING),
    )
    return AccessControl(dict.fromkeys(names, rules))
