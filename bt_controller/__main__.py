"""The console script ``bt-controller``; ``python -m bt_controller`` is the same."""

from __future__ import annotations

import sys

from hmrsim.program.signals import INTERRUPTED, leave, must_leave


def main() -> int:
    """Run the command and return its exit code, also when it is interrupted while its modules load."""
    try:
        from bt_controller.cli import main as run  # noqa: PLC0415 - what takes its time

        code = run()
    except KeyboardInterrupt:
        code = INTERRUPTED
    if must_leave(code):
        leave(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
