"""The command ``hmrsim``: one file a command.

Commands turn options into settings, and give these to a host, a simulator or a client; nothing imports them.
"""

from hmrsim.cli.start import main

__all__ = ["main"]
