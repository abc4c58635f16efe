"""``python -m hmrsim.cli`` is ``hmrsim``."""

import sys

from hmrsim.cli import main

if __name__ == "__main__":
    sys.exit(main())
