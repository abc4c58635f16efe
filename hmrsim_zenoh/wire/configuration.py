"""Zenoh configurations: reading a file, and checking whether endpoints are open to other machines."""

from __future__ import annotations

import json
import re
from itertools import accumulate
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim.errors import reason_of
from hmrsim.program.files import check_regular
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.wire.options import ENCRYPTED, address_of, is_loopback

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from hmrsim_zenoh.wire.options import SessionOptions


MAX_CONFIG: Final = 1 << 20
"""The largest configuration file in bytes."""
_MAX_CONFIG_DEPTH: Final = 50
"""Maximum depth of nested lists and objects in a configuration file; Zenoh's own have seven levels."""

# The build path of Zenoh's Rust source, which it appends to its messages.
_SOURCE: Final = re.compile(r"\s+at /\S+\.rs:\d+\.?")
_JSON5: Final = re.compile(r'Json5Err\(Message \{ msg: "(?P<text>.*?)", location')

_SECURING: Final = ("access_control/enabled", "transport/auth/usrpwd/dictionary_file")
"""The settings of a Zenoh configuration that restrict access at all endpoints."""

_CERTIFIED: Final = "transport/link/tls/enable_mtls"
"""The setting that restricts access at encrypted endpoints."""


def base_config(config_file: Path | None) -> zenoh.Config:
    """Return the configuration of a file, or Zenoh's own.

    Raises:
        BadOptions: It can't be read.
    """
    if config_file is None:
        return zenoh.Config()
    try:
        # Zenoh would wait for a pipe without letting go of the interpreter.
        check_regular(config_file)
        flaw = _too_much(config_file)
    except FileNotFoundError:
        flaw = ""  # Zenoh reports this
    except OSError as error:
        raise BadOptions(f"{config_file}: can't be read: {reason_of(error)}") from None
    if flaw:
        raise BadOptions(f"{config_file}: not a Zenoh configuration: {flaw}")
    try:
        return zenoh.Config.from_file(config_file)
    except zenoh.ZError as error:
        raise BadOptions(f"{config_file}: not a Zenoh configuration: {first_line(error)}") from None


def _too_much(config_file: Path) -> str:
    """Return why a file is too large for Zenoh, which crashes when JSON5 is nested too deep; empty if it is not."""
    with config_file.open("rb") as file:
        text = file.read(MAX_CONFIG + 1)
    if len(text) > MAX_CONFIG:
        return f"larger than {MAX_CONFIG} bytes"
    depths = accumulate(1 if bracket in b"[{" else -1 for bracket in re.findall(rb"[][{}]", text))
    return f"nested deeper than {_MAX_CONFIG_DEPTH}" if max(depths, default=0) > _MAX_CONFIG_DEPTH else ""


def exposed(options: SessionOptions, endpoints: Sequence[str]) -> list[str]:
    """Return the endpoints that other machines can reach, without a certificate or another secret."""
    if options.secure:
        return []
    config = base_config(options.zenoh_config)
    if any(json.loads(config.get_json(key)) for key in _SECURING):
        return []
    certified = ENCRYPTED if json.loads(config.get_json(_CERTIFIED)) else ()
    open_to_all = [endpoint for endpoint in endpoints if endpoint.partition("/")[0] not in certified]
    addresses = {endpoint: address_of(endpoint) for endpoint in open_to_all}
    return [endpoint for endpoint, address in addresses.items() if address and not is_loopback(address[0])]


def first_line(error: zenoh.ZError) -> str:
    """Return the first line of Zenoh's message, without the location in its source."""
    text = str(error)
    if found := _JSON5.search(text):
        text = found["text"]
    text = _SOURCE.sub("", text)
    return next((line for line in text.splitlines() if line.strip()), "unknown error").strip()
