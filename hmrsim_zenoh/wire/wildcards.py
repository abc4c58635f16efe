"""Key expressions that a server holds for itself, spelled as no client spells them."""

from __future__ import annotations

from typing import Final

_ANY: Final = "**"


def servers_own(key_expr: str) -> str:
    """Return another spelling of a key expression with wildcards; it includes all keys that the first one includes.

    Zenoh 1.10 keeps what it knows of a closed session, 2.7 kB, as long as the server itself holds the very key
    expression with wildcards that the session had subscribed to and unsubscribed from: sessions that come and go
    would fill memory. So the server declares publishers and queryables not on ``hmrsim/**`` or ``hmrsim/*/odom``, but
    on ``hmrsim/*/**`` and ``hmrsim/*/$*odom``.

    Args:
        key_expr: A canonical key expression. It is returned as it is if it has no wildcard, or nothing but ``*``
            after the first one.
    """
    chunks = key_expr.split("/")
    if _ANY in chunks:
        chunks.insert(chunks.index(_ANY), "*")
        return "/".join(chunks)
    wild = False
    last = None
    for at, chunk in enumerate(chunks):
        if "*" in chunk:
            wild = True
        elif wild:
            last = at
    if last is not None:
        chunks[last] = f"$*{chunks[last]}"
    return "/".join(chunks)
