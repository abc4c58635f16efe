"""The live view: a page in a browser, and the server that connects it to Zenoh.

`server.ViewServer` serves a `live.Live` or a `recorded.Recorded`; these modules load Starlette and Uvicorn, which
commands that only print help do not need.
"""

from typing import Final

DEFAULT_HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 7448

__all__ = ["DEFAULT_HOST", "DEFAULT_PORT"]
