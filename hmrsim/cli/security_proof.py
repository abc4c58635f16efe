"""What ``hmrsim security check`` does: it tries everything at a running simulator, and shows a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import columns, show, show_json
from hmrsim.cli.security_folder import folder_of_environment
from hmrsim.cli.security_store import keystore
from hmrsim.settings.arguments import read_settings
from hmrsim_zenoh.security.check import attempts
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    import argparse


def check(args: argparse.Namespace) -> int:
    """Try everything at a running simulator; return 1 if it does not enforce the policy."""
    store, options = keystore(args.keystore or folder_of_environment()), read_settings(args, SessionOptions)
    found = list(attempts(store, options))
    wrong = [one for one in found if not one.as_expected]
    if args.json:
        tried = [{"who": one.who, "what": one.what, "allowed": one.expected, "done": one.done} for one in found]
        show_json({"attempts": tried, "wrong": len(wrong)})
    else:
        rows = [("who", "tries", "policy", "simulator", "")]
        rows += [
            (one.who, one.what, _verdict(one.expected), _verdict(one.done), "" if one.as_expected else "WRONG")
            for one in found
        ]
        show("\n".join(columns(rows)))
        text = "the simulator enforces the policy" if not wrong else "it does not enforce the policy; restart it"
        show(f"{len(found) - len(wrong)} of {len(found)} as the policy says: {text}")
    return ExitCode.FAILED if wrong else ExitCode.DONE


def _verdict(allowed: bool) -> str:  # noqa: FBT001 - the one value that it words
    return "allows" if allowed else "denies"
