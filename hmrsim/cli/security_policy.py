"""``hmrsim security explain``: who may do what on a key, by the policy of a keystore or an enclave."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import columns, show_result
from hmrsim.cli.security import VARIABLE
from hmrsim_zenoh.wire.enclave import DESCRIPTION, ENCLAVES, enclaves, find_enclave, read_enclave

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.access_control import AccessControl, Decision, Message
    from hmrsim_zenoh.wire.enclave import Enclave

_ASKS: Final[Mapping[str, tuple[Message, Message]]] = {
    "ask": ("query", "reply"),
    "subscribe": ("declare_subscriber", "put"),
}
"""Operations of a client, with the message that it sends and the one that it receives."""
_DOES: Final[Mapping[str, Message]] = {
    "publish": "put",
    "answer": "declare_queryable",
    "be present": "liveliness_token",
    "see presence": "declare_liveliness_subscriber",
}
"""Operations of a client to which no message is returned."""

_KEY_AND_ROLE: Final = 2
"""The number of words without the folder."""


def explain(args: argparse.Namespace) -> int:
    """Print who may do what on a key, and by which rule; return the exit code."""
    folder, text, role = _parsed(args.words)
    try:
        key = str(zenoh.KeyExpr(text))
    except zenoh.ZError:
        raise WrongUse(f"{text!r} is not a key expression; chunks are joined by single slashes") from None
    chosen = _chosen(folder, role)
    policy = chosen[0].access_control
    alone = (folder / DESCRIPTION).exists() and role is None
    names = list(policy.rules) if alone else [enclave.name for enclave in chosen]
    decided = {name: decisions(policy, name, key) for name in names}
    facts = {
        name: {what: {"allowed": decision.allowed, "rule": decision.rule} for what, decision in each.items()}
        for name, each in decided.items()
    }
    rows = [
        (
            name,
            "may" if decision.allowed else "may not",
            what,
            f"rule {decision.rule!r}" if decision.rule else "no rule allows it",
        )
        for name, each in decided.items()
        for what, decision in each.items()
    ]
    show_result({"key": key, "enclaves": facts}, columns(rows), as_json=args.json)
    return ExitCode.DONE


def decisions(policy: AccessControl, name: str, key: str) -> dict[str, Decision]:
    """Return the policy's decision on each operation of a client on a key."""
    decided = {}
    for what, (sent, received) in _ASKS.items():
        first, second = policy.decide(name, sent, "ingress", key), policy.decide(name, received, "egress", key)
        decided[what] = second if first.allowed and not second.allowed else first
    return decided | {what: policy.decide(name, message, "ingress", key) for what, message in _DOES.items()}


def _parsed(words: Sequence[str]) -> tuple[Path, str, str | None]:
    """Return the folder, the key, and the role if given.

    Raises:
        WrongUse: There are too many words, or too few.
    """
    rest = list(words)
    first = Path(rest[0])
    if len(rest) > _KEY_AND_ROLE or (first / DESCRIPTION).exists() or (first / ENCLAVES).exists():
        folder = Path(rest.pop(0))
    else:
        folder = folder_of_environment()
    if not 1 <= len(rest) <= _KEY_AND_ROLE:
        raise WrongUse("expected [DIR] KEY [ROLE], such as keys hmrsim/wall_e/odom viewer")
    return folder, rest[0], rest[1] if len(rest) > 1 else None


def _chosen(folder: Path, role: str | None) -> list[Enclave]:
    if role is not None:
        return [find_enclave(folder, role)]
    if (folder / DESCRIPTION).exists():
        return [read_enclave(folder)]
    return enclaves(folder) or [find_enclave(folder, "")]


def folder_of_environment() -> Path:
    """Return the keystore's folder from the environment.

    Raises:
        WrongUse: The environment does not name one.
    """
    folder = os.environ.get(VARIABLE, "")
    if not folder:
        raise WrongUse(f"no keystore; name its folder DIR, or set {VARIABLE}=DIR")
    return Path(folder)
