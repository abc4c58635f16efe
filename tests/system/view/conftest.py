"""The page's server and its simulator, as in tests of the wire."""

from tests.wire.view.conftest import open_page, page, server, session, simulator, wait_for_listener  # noqa: F401
