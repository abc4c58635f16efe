"""Checks the locked dependencies for known vulnerabilities with pip-audit, and reports if no index answers.

Run as ``python -m tools.audit``; it needs pip-audit, which `make audit` installs.
"""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any, Final

_LOCK: Final = "requirements.lock"
_COMMAND: Final = (
    sys.executable,
    "-m",
    "pip_audit",
    "--requirement",
    _LOCK,
    "--require-hashes",
    "--disable-pip",
    "--progress-spinner=off",
    "--format=json",
)
_TIMEOUT: Final = 300.0


def main() -> int:
    """Print the known vulnerabilities of the locked packages; return 1 if there are any."""
    try:
        done = subprocess.run(_COMMAND, capture_output=True, text=True, timeout=_TIMEOUT, check=False)  # noqa: S603 - ours
        found = json.loads(done.stdout)["dependencies"]
    except subprocess.TimeoutExpired:
        return _skipped(f"no answer in {_TIMEOUT:g} s")
    except (ValueError, KeyError):
        return _skipped((done.stderr.strip() or "pip-audit says nothing").splitlines()[-1])
    audited = [one for one in found if "vulns" in one]
    if not audited:
        return _skipped(found[0].get("skip_reason", "the index knows no package") if found else "nothing is locked")
    vulnerable = [text for one in audited for text in _texts(one)]
    for text in vulnerable:
        sys.stdout.write(f"{text}\n")
    sys.stdout.write(f"{len(audited)} of {len(found)} packages audited: {len(vulnerable)} known vulnerabilities\n")
    return 1 if vulnerable else 0


def _texts(package: dict[str, Any]) -> list[str]:
    return [
        f"{package['name']} {package['version']}: {vuln['id']}, fixed in {', '.join(vuln['fix_versions']) or 'none'}"
        for vuln in package["vulns"]
    ]


def _skipped(why: str) -> int:
    sys.stdout.write(f"not audited: {why}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
