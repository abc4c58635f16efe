"""Runs ``hmrsim`` as ``python -m hmrsim.cli``."""

import sys

from hmrsim.cli import main

if __name__ == "__main__":
    sys.exit(main())
