"""The live picture: a page in a browser, and the small server that is its Zenoh.

`server.ViewServer` serves what `live.Live` or `recorded.Recorded` has to show; they load Starlette and Uvicorn, which
commands that only print help do not need.
"""

from typing import Final

DEFAULT_HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 7448

__all__ = ["DEFAULT_HOST", "DEFAULT_PORT"]
