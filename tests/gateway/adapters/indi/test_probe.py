"""What is seen of a real INDI server, and what is made of it."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable

import msgspec
import pytest

from talaia.gateway.adapters.indi.probe import probe_server
from talaia.gateway.errors import AdapterLost
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import Found
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

pytestmark = pytest.mark.robot
DRIVERS = tuple(f"indi_simulator_{each}" for each in ("telescope", "dome", "weather"))


async def seen(port: int, *, connect: bool = False) -> Found:
    return await asyncio.to_thread(probe_server, "127.0.0.1", port, 20.0, connect=connect)


async def test_a_probe_lists_devices_and_properties_and_connects_nothing(
    indi: Callable[..., object],
) -> None:
    async with indi(*DRIVERS) as server:
        found = await seen(server.port)
        again = await seen(server.port)
    assert [each.device for each in found.devices] == [
        "Dome Simulator", "Telescope Simulator", "Weather Simulator",
    ]  # fmt: skip
    assert not any(each.connected for each in again.devices)
    (info,) = [each for each in found.devices[0].properties if each.property == "CONNECTION"]
    assert info.type == "switch"
    assert info.writable
    assert {each.element: each.value for each in info.elements}["CONNECT"] == "off"
    assert found.devices[0].driver.startswith("indi_simulator_dome")
    made = propose_description(found, "sky", "Sky", "UTC")
    assert made.site.devices == {}
    assert "Dome Simulator, Telescope Simulator" in made.left_out[0]
    assert check_site(made.site) == []


async def test_connected_drivers_are_described_with_names_and_units_and_run_as_they_are(
    indi: Callable[..., object],
) -> None:
    async with indi(*DRIVERS) as server:
        found = await seen(server.port, connect=True)
    assert msgspec.json.decode(msgspec.json.encode(found), type=Found) == found
    assert all(each.connected for each in found.devices)
    site = propose_description(found, "sky", "Sky", "UTC").site
    assert check_site(site) == []
    assert load_site(write_description(site)) == site
    assert site.connections["indi"].port == found.port
    weather = site.devices["weather_simulator"].signals
    assert weather["temperature"].unit == "°C"
    assert weather["temperature"].primary
    assert site.devices["dome_simulator"].signals["azimuth"].unit == "°"
    assert "goto" in site.devices["telescope_simulator"].commands


async def test_settings_that_a_driver_calls_alike_say_what_each_of_them_sets(
    indi: Callable[..., object],
) -> None:
    async with indi("indi_simulator_focus") as server:
        found = await seen(server.port, connect=True)
    site = propose_description(found, "sky", "Sky", "UTC").site
    names = [command.name for command in site.devices["focuser_simulator"].commands.values()]
    assert len(set(names)) == len(names)
    assert {"Set Backlash (Enabled, Disabled)", "Set Backlash (Steps)"} <= set(names)


async def test_a_server_that_is_not_there_is_told_with_its_address() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        with pytest.raises(AdapterLost, match=f"127.0.0.1:{port} cannot be reached"):
            await seen(port)


@pytest.mark.parametrize(
    ("said", "why"), [(b"<a></b>", "not INDI"), (b"SSH-2.0\r\n", "closed the connection")]
)
async def test_what_is_no_indi_server_is_told(said: bytes, why: str) -> None:
    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readline()
        writer.write(said)
        writer.close()

    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    async with server:
        port = server.sockets[0].getsockname()[1]
        with pytest.raises(AdapterLost, match=why):
            await seen(port)
