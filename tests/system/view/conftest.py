"""A page's server with a simulator behind it, as in the tests of the wire."""

from tests.wire.view.conftest import open_page, page, server, session, simulator, wait_for_listener  # noqa: F401
