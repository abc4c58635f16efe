"""The check whether endpoints of a simulator are open to other machines."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.wire.enclave import PROTOCOLS
from hmrsim_zenoh.wire.endpoints import address_of, is_loopback
from hmrsim_zenoh.wire.session import base_config

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim_zenoh.wire.options import SessionOptions

_SECURING: Final = ("access_control/enabled", "transport/auth/usrpwd/dictionary_file")
"""The settings of a Zenoh configuration that restrict access at all endpoints."""

_CERTIFIED: Final = "transport/link/tls/enable_mtls"
"""The setting that restricts access at encrypted endpoints."""


def exposed(options: SessionOptions, endpoints: Sequence[str]) -> list[str]:
    """Return the endpoints that other machines can reach, without a certificate or another secret."""
    if options.secure:
        return []
    config = base_config(options.zenoh_config)
    if any(json.loads(config.get_json(key)) for key in _SECURING):
        return []
    certified = PROTOCOLS if json.loads(config.get_json(_CERTIFIED)) else ()
    open_to_all = [endpoint for endpoint in endpoints if endpoint.partition("/")[0] not in certified]
    addresses = {endpoint: address_of(endpoint) for endpoint in open_to_all}
    return [endpoint for endpoint, address in addresses.items() if address and not is_loopback(address[0])]
