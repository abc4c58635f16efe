"""The launcher and the tools: ``hmrsim``. One file a command group; here is where everything is wired."""

from hmrsim.cli.start import main

__all__ = ["main"]
