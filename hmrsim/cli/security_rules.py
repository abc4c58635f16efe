"""What ``hmrsim security explain`` does: it reads the policy of a keystore, or of one enclave."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import columns, show, show_json
from hmrsim.cli.security_folder import folder_of_environment
from hmrsim_zenoh.wire.enclave import DESCRIPTION, ENCLAVES, enclaves, find_enclave, read_enclave

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.access_control import AccessControl, Decision, Message
    from hmrsim_zenoh.wire.enclave import Enclave

_ASKS: Final[Mapping[str, tuple[Message, Message]]] = {
    "ask": ("query", "reply"),
    "subscribe": ("declare_subscriber", "put"),
}
"""What a client does, by the message from the client and the one that comes back."""
_DOES: Final[Mapping[str, Message]] = {
    "publish": "put",
    "answer": "declare_queryable",
    "be present": "liveliness_token",
    "see presence": "declare_liveliness_subscriber",
}
"""Likewise, where nothing comes back."""

_KEY_AND_ROLE: Final = 2
"""The number of words without the folder."""


def explain(args: argparse.Namespace) -> int:
    """Say who may do what on a key, and by which rule."""
    folder, text, wanted = _parted(args.words)
    try:
        key = str(zenoh.KeyExpr(text))
    except zenoh.ZError:
        raise WrongUse(f"{text!r} is not a key expression; chunks are joined by single slashes") from None
    chosen = _chosen(folder, wanted)
    policy = chosen[0].access_control
    alone = (folder / DESCRIPTION).exists() and wanted is None
    names = list(policy.rules) if alone else [enclave.name for enclave in chosen]
    found = {name: decisions(policy, name, key) for name in names}
    if args.json:
        told = {
            name: {what: {"allowed": one.allowed, "rule": one.rule} for what, one in each.items()}
            for name, each in found.items()
        }
        show_json({"key": key, "enclaves": told})
        return ExitCode.DONE
    rows = [
        (name, "may" if one.allowed else "may not", what, f"rule {one.rule!r}" if one.rule else "no rule allows it")
        for name, each in found.items()
        for what, one in each.items()
    ]
    show("\n".join(columns(rows)))
    return ExitCode.DONE


def decisions(policy: AccessControl, name: str, key: str) -> dict[str, Decision]:
    """Return what the policy says of each thing that a client can do on a key."""
    found = {}
    for what, (there, back) in _ASKS.items():
        first, second = policy.decide(name, there, "ingress", key), policy.decide(name, back, "egress", key)
        found[what] = second if first.allowed and not second.allowed else first
    return found | {what: policy.decide(name, message, "ingress", key) for what, message in _DOES.items()}


def _parted(words: Sequence[str]) -> tuple[Path, str, str | None]:
    """Return the folder, the key, and the role if there is one.

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


def _chosen(folder: Path, wanted: str | None) -> list[Enclave]:
    if wanted is not None:
        return [find_enclave(folder, wanted)]
    if (folder / DESCRIPTION).exists():
        return [read_enclave(folder)]
    return enclaves(folder) or [find_enclave(folder, "")]
