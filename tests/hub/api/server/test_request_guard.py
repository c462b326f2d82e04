"""Which hosts and origins are the hub itself."""

import pytest

from talaia.hub.api.server.request_guard import host_name, same_origin

pytestmark = pytest.mark.pure


def test_host_names_are_told_from_ports() -> None:
    assert [host_name(each) for each in ("Hub:8443", "hub", "[::1]:80", "[::1]")] == [
        "hub",
        "hub",
        "::1",
        "::1",
    ]


def test_only_the_very_same_origin_is_the_same() -> None:
    assert same_origin("https://hub:8443", "hub:8443", tls=True)
    for origin in ("http://hub:8443", "https://hub", "https://hub:8443/", "null", "", None):
        assert not same_origin(origin, "hub:8443", tls=True)
