"""Where a network camera may be."""

from __future__ import annotations

import pytest

from talaia.model.camera_addresses import remedy_for, why_no_camera


@pytest.mark.parametrize(
    "address",
    ["192.168.1.20", "10.0.0.7", "172.16.4.4", "203.0.114.9", "fd12:3456::7", "2a00:1450::1"],
)
def test_a_camera_may_be_on_a_private_network_or_a_public_one(address: str) -> None:
    assert not why_no_camera(address)


@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("0.0.0.0", "nobody's"),  # noqa: S104
        ("0.1.2.3", "nobody's"),
        ("::", "nobody's"),
        ("169.254.169.254", "metadata"),
        ("169.254.3.4", "link-local"),
        ("fe80::1", "link-local"),
        ("fe80::1%eth0", "link-local"),
        ("febf::1", "link-local"),
        ("224.0.0.1", "multicast"),
        ("ff02::1", "multicast"),
        ("255.255.255.255", "reserved"),
        ("fd00:ec2::254", "metadata"),
        ("100.100.100.200", "metadata"),
        ("168.63.129.16", "metadata"),
        ("::ffff:169.254.169.254", "metadata"),
        ("::169.254.169.254", "metadata"),
        ("64:ff9b::a9fe:a9fe", "metadata"),
        ("2002:a9fe:a9fe::1", "metadata"),
        ("camera.local", "no IP"),
        ("", "no IP"),
    ],
)
def test_no_camera_is_where_only_the_gateway_gets_to(address: str, why: str) -> None:
    assert why in why_no_camera(address, here=True)


@pytest.mark.parametrize(
    "address", ["127.0.0.1", "127.9.9.9", "::1", "::ffff:127.0.0.1", "64:ff9b::7f00:1"]
)
def test_a_camera_is_on_this_computer_only_where_the_connection_says_so(address: str) -> None:
    why = why_no_camera(address)
    assert "this computer" in why
    assert "here: true" in remedy_for(why)
    assert not why_no_camera(address, here=True)
