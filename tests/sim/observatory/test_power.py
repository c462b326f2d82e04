"""Devices of the simulated observatory obey the outlets that they hang on."""

from __future__ import annotations

import pytest

from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.catalog import make_server
from talaia.sim.observatory.servers.devices import MONTSEC

NIGHT = 1_795_302_000.0  # 2026-11-21 23:00 UTC
OUTLETS = {"dome": "/pdu/on1", "telescope": "/pdu/on2", "camera": "/pdu/on3", "cctv": "/pdu/on7"}


def server_of(name: str):
    return make_server(name, seed=1, unix_s=NIGHT, call=lambda *_: Ticket.done(""), place=MONTSEC)


@pytest.mark.parametrize("name", OUTLETS)
def test_a_device_without_power_says_nothing_and_refuses_all_until_it_has_power(name: str) -> None:
    server = server_of(name)
    _, feed = server.hears[OUTLETS[name]]
    feed(True)  # noqa: FBT003
    assert (server.silent, server.without_power()) == (False, None)
    feed(False)  # noqa: FBT003
    assert server.silent
    refused = server.without_power()
    assert refused is not None
    assert (refused.good, "has no power" in refused.message) == (False, True)
    feed(True)  # noqa: FBT003
    assert (server.silent, server.without_power()) == (False, None)


def test_a_dome_that_loses_power_half_open_stands_and_does_not_go_on_when_power_is_back() -> None:
    server = server_of("dome")
    ticket = server.triggers["open"]()
    server.pass_time(6.0, NIGHT)
    position = server.model.position
    assert 0 < position < 1
    server.set_power(False)
    assert (ticket.ended, ticket.good) == (True, False)
    for on in (False, True):
        server.set_power(on)
        server.pass_time(30.0, NIGHT)
        assert server.model.position == position
    assert server.topic_values()["status"] == "stopped"
    assert not server.topic_values()["closed"]


def test_a_camera_without_power_loses_its_exposure_and_its_cold() -> None:
    server = server_of("camera")
    server.asks["cool"].act(celsius=-10.0)
    ticket = server.asks["expose"].act(seconds=30.0, frame="dark", target="")
    server.set_power(False)
    assert (ticket.ended, ticket.good, server.model.cooling) == (True, False, False)


def test_what_hangs_on_no_outlet_needs_none() -> None:
    for name in ("weather", "pdu", "observatory"):
        server = server_of(name)
        assert not any(each.startswith("/pdu/on") for each in server.hears)
        assert not server.silent
