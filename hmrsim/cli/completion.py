"""``hmrsim completion``: the shell scripts that complete the commands."""

from __future__ import annotations

import argparse
from typing import Final

from argcomplete.shell_integration import shellcode

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show

_PROGRAMS: Final = ("hmrsim", "bt-controller")

_EXAMPLES: Final = """\
examples:
  hmrsim completion bash >> ~/.bashrc
  eval "$(hmrsim completion zsh)"         # in ~/.zshrc, after: autoload -U compinit && compinit
  hmrsim completion fish > ~/.config/fish/completions/hmrsim.fish

Names of robots, actions, topics and services are those of the running simulator, if one answers at once at
HMRSIM_CONNECT or at the default endpoint."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim completion``."""
    parser.description = "Print a script that makes a shell complete `hmrsim` and `bt-controller`."
    parser.epilog = _EXAMPLES
    parser.add_argument("shell", metavar="SHELL", choices=("bash", "zsh", "fish"), help="bash, zsh or fish")
    parser.set_defaults(function=_print_script)


def _print_script(args: argparse.Namespace) -> int:
    show(shellcode(_PROGRAMS, shell=args.shell).rstrip("\n"))
    return ExitCode.DONE
