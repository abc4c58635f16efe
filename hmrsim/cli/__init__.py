"""The command ``hmrsim``: one file per command.

Commands convert options to settings, and pass these to a host, a simulator or a client; no package imports them.
"""

from hmrsim.cli.start import main

__all__ = ["main"]
