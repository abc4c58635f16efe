"""The console script ``bt-controller``; ``python -m bt_controller`` is the same."""

from __future__ import annotations

import sys

_INTERRUPTED = 130


def main() -> int:
    """Run the command and return its exit code, also when it is interrupted while its modules load."""
    try:
        from bt_controller.cli import main as run  # noqa: PLC0415 - what takes its time

        return run()
    except KeyboardInterrupt:
        return _INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
