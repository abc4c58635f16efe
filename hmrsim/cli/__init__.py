"""The command ``hmrsim``: one file for each of its commands.

A command turns options into settings, and passes them to a host, a simulator or a client.
"""

from hmrsim.cli.entry import main

__all__ = ["main"]
