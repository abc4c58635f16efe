"""``hmrsim security``: the commands for keystores, each loaded when it is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.program.command_line import Later, add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import LazyParser

_COMMANDS: Final = {
    "create": "make a keystore: an authority, and an enclave for each role",
    "add": "add an enclave to a keystore",
    "renew": "make new certificates, which are valid for longer",
    "revoke": "take all rights from an enclave",
    "explain": "say who may do what on a key, and by which rule",
    "check": "prove at a running simulator that it enforces the policy",
}
"""Each is a module ``security_…`` with a function *configure*, which adds arguments to the command's parser."""

_EXAMPLES: Final = """\
examples:
  hmrsim security create keys && hmrsim run hospital --secure keys
  hmrsim action send-goal --secure keys /wall_e/wait '{time: {sec: 3}}'
  hmrsim security create keys --host 10.0.0.7 --controller nurses=wall_e,eve --controller porters=m_o
  hmrsim security add keys viewer lobby
  hmrsim security explain keys hmrsim/wall_e/wait/_action/send_goal
  hmrsim security check keys"""


def configure(parser: LazyParser) -> None:
    """Add the commands of ``hmrsim security``."""
    parser.description = (
        "Let only those drive robots who have a certificate for it. A keystore has an authority, and an enclave (a\n"
        "certificate, its key and the policy) for each role; commands use it by --secure DIR or HMRSIM_SECURE=DIR."
    )
    parser.epilog = _EXAMPLES
    add_commands(parser, {name: (text, Later(f"{__name__}_{name}", "configure")) for name, text in _COMMANDS.items()})
