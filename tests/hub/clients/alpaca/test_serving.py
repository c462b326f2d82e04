"""The hub as an Alpaca server, with PyPI's alpyca as the client."""

# ruff: noqa: ASYNC110 - a server is asked

from __future__ import annotations

import asyncio
import dataclasses
from typing import Any

import httpx
import pytest
import pytest_asyncio
import yaml
from alpaca import discovery, management
from alpaca.dome import Dome, ShutterState
from alpaca.exceptions import (
    InvalidOperationException,
    NotImplementedException,
    ValueNotSetException,
)
from alpaca.observingconditions import ObservingConditions
from alpaca.safetymonitor import SafetyMonitor
from patience import PATIENCE_S
from ports import free_port
from shared_trust import usual_trust

from talaia.clock import SystemClock
from talaia.hub.clients.alpaca.listener import answer_discovery
from talaia.model.yaml_text.load import load_site
from talaia.wire import frames
from talaia.wire.frames import CommandPhase

from ...conftest import MemoryHistory, RunningHub
from ..tokens import open_protocol, token_of
from .observatory_site import OBSERVATORY

pytestmark = pytest.mark.asyncio(loop_scope="module")


class Served:
    """A hub that serves an observatory, and the gateway behind it."""

    def __init__(self, hub: Any, gateway: Any, folder: Any, port: int) -> None:  # noqa: D107
        self.hub, self.gateway, self.folder, self.port = hub, gateway, folder, port
        self.address = f"127.0.0.1:{port}"

    async def opens(self, name: str = "operator", *, is_open: bool = True) -> None:
        """Serve by the rights of somebody from now on, or not at all."""
        await open_protocol(self.hub, "alpaca", is_open=False)
        await self.until(self.answers, wanted=False)
        (self.folder / "token").write_text(await token_of(self.hub, name))
        await open_protocol(self.hub, "alpaca", is_open=is_open)
        await self.until(self.answers, wanted=is_open)

    async def answers(self) -> bool:
        try:
            async with httpx.AsyncClient(verify=usual_trust()) as client:
                url = f"http://{self.address}/management/apiversions"
                return (await client.get(url)).status_code == 200
        except httpx.TransportError:
            return False

    async def until(self, ask: Any, wanted: object) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while await ask() != wanted:
                await asyncio.sleep(0.02)

    async def fine(self) -> None:
        """Have the gateway say that all is known and fine, now."""
        now_us = SystemClock().wall_ns() // 1000
        await self.gateway.samples(
            ("dome/shutter", now_us, 0.0),
            ("dome/azimuth", now_us, 10.0),
            ("weather/wind", now_us, 36.0),
            ("weather/temperature", now_us, -3.0),
            ("weather/status", now_us, 0.0),
        )
        await self.gateway.say(frames.InterlockState(interlock="rain", locked=False))
        await self.until(lambda: self.read(SafetyMonitor, "IsSafe"), wanted=True)

    async def read(self, kind: Any, name: str) -> Any:
        # alpyca blocks, and the hub is in this thread.
        return await asyncio.to_thread(lambda: getattr(kind(self.address, 0), name))

    async def call(self, name: str, *args: object) -> None:
        await asyncio.to_thread(lambda: getattr(Dome(self.address, 0), name)(*args))


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def served(shared_settings, tmp_path_factory):
    folder, port = tmp_path_factory.mktemp("alpaca"), free_port()
    said = {
        "address": "127.0.0.1",
        "port": port,
        "site": "agv",
        "token_file": "token",
        "commands": ["dome/open", "dome/turn"],
        "discovery": False,
    }
    (folder / "alpaca.yaml").write_text(yaml.safe_dump(said))
    (folder / "token").write_text("none yet")
    settings = dataclasses.replace(shared_settings, alpaca=folder / "alpaca.yaml")
    async with RunningHub(settings, MemoryHistory()) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(OBSERVATORY)
        gateway.channels = {
            channel.address: at for at, channel in enumerate(load_site(OBSERVATORY).channels())
        }
        yield Served(hub, gateway, folder, port)


async def test_it_is_shut_until_an_admin_opens_it(served) -> None:
    assert not await served.answers()
    await served.opens()
    await served.opens(is_open=False)


async def test_alpyca_reads_dome_weather_and_safety(served) -> None:
    await served.opens()
    await served.fine()
    found = await asyncio.to_thread(management.configureddevices, served.address)
    kinds = [(one["DeviceType"], one["DeviceNumber"]) for one in found]
    assert kinds == [("Dome", 0), ("ObservingConditions", 0), ("SafetyMonitor", 0)]
    described = await asyncio.to_thread(management.description, served.address)
    assert described["ServerName"] == "Talaia"
    assert await served.read(Dome, "ShutterStatus") == ShutterState.shutterClosed
    assert await served.read(Dome, "Azimuth") == 10.0
    assert await served.read(Dome, "Slewing") is False
    assert await served.read(Dome, "CanSetShutter") is True
    assert await served.read(Dome, "CanPark") is False
    assert await served.read(ObservingConditions, "WindSpeed") == pytest.approx(10.0)
    assert await served.read(ObservingConditions, "Temperature") == -3.0
    with pytest.raises(NotImplementedException):
        await served.read(ObservingConditions, "Humidity")
    assert await served.read(SafetyMonitor, "InterfaceVersion") == 3
    assert await served.read(SafetyMonitor, "Connected") is True


async def test_alpyca_is_told_unsafe_when_the_gateway_is_lost(served) -> None:
    await served.opens()
    await served.fine()
    await served.gateway.connection.close()
    await served.until(lambda: served.read(SafetyMonitor, "IsSafe"), wanted=False)
    with pytest.raises(ValueNotSetException):
        await served.read(Dome, "ShutterStatus")
    served.gateway = await served.hub.gateway()
    await served.gateway.hello(OBSERVATORY, boot="boot-2")
    served.gateway.channels = {
        channel.address: at for at, channel in enumerate(load_site(OBSERVATORY).channels())
    }
    # What was so before the loss counts for nothing.
    assert await served.read(SafetyMonitor, "IsSafe") is False
    await served.fine()


async def test_a_permitted_command_passes_the_gate_and_a_refusal_comes_back_in_words(
    served,
) -> None:
    await served.opens()
    asking = asyncio.create_task(served.call("OpenShutter"))
    asked = await served.gateway.hear(frames.CommandRequest)
    assert (asked.device, asked.command) == ("dome", "open")
    assert asked.who == "operator by Alpaca 127.0.0.1"
    await end_command(served, asked, CommandPhase.REFUSED, "rain: wet")
    with pytest.raises(InvalidOperationException, match="rain: wet"):
        await asking
    # It runs, and that is all that ASCOM waits for.
    asking = asyncio.create_task(served.call("SlewToAzimuth", 90.0))
    asked = await served.gateway.hear(frames.CommandRequest)
    assert asked.args == {"azimuth": 90.0}
    await end_command(served, asked, CommandPhase.RUNNING, "")
    await asking
    await end_command(served, asked, CommandPhase.SUCCEEDED, "")


async def test_who_may_do_anything_with_a_dome_may_close_it(served) -> None:
    await served.opens()
    asking = asyncio.create_task(served.call("CloseShutter"))
    asked = await served.gateway.hear(frames.CommandRequest)
    assert asked.command == "close"
    await end_command(served, asked, CommandPhase.SUCCEEDED, "closed")
    await asking


async def test_what_is_not_permitted_moves_nothing_and_is_audited(served) -> None:
    await served.opens()
    for name in ("Park", "FindHome", "AbortSlew"):
        with pytest.raises(NotImplementedException):
            await served.call(name)
    # A guest's rights do not reach the dome, whatever the file permits.
    await served.opens("guest")
    with pytest.raises(Exception, match="no such device"):
        await served.call("OpenShutter")
    await served.opens("operator")
    client = await served.hub.client("admin")
    rows = (await client.get("/api/audit?limit=50")).json()["rows"]
    refused = [row for row in rows if row["kind"] == "alpaca command refused"]
    assert any("findhome" in row["message"] for row in refused)
    assert any(
        row["kind"] == "command asked" and "by Alpaca 127.0.0.1" in row["who"] for row in rows
    )
    assert not any(isinstance(one, frames.CommandRequest) for one in served.gateway.heard)


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": "https://evil.test"}, 403),
        ({"Origin": "null"}, 403),
        ({"Host": "evil.test:11111"}, 403),
        ({}, 200),
    ],
)
async def test_pages_of_browsers_are_refused(served, headers, status) -> None:
    await served.opens()
    async with httpx.AsyncClient(verify=usual_trust()) as client:
        url = f"http://{served.address}/management/v1/description"
        assert (await client.get(url, headers=headers)).status_code == status


@pytest.mark.parametrize(
    ("method", "path", "body", "status"),
    [
        ("GET", "/api/v1/dome/1/azimuth", None, 400),
        ("GET", "/api/v1/telescope/0/rightascension", None, 400),
        ("GET", "/api/v1/dome/0/azimuth?ClientTransactionID=-1", None, 400),
        ("GET", "/api/v1/dome/0", None, 404),
        ("GET", "/api/history", None, 404),
        ("PUT", "/api/v1/dome/0/launch", "x=1", 400),
        ("PUT", "/api/v1/dome/0/openshutter", "x" * 9000, 413),
        ("POST", "/api/v1/dome/0/openshutter", "", 405),
        ("DELETE", "/management/v1/description", None, 405),
    ],
)
async def test_what_cannot_be_read_is_answered_with_a_status(
    served, method, path, body, status
) -> None:
    await served.opens()
    async with httpx.AsyncClient(verify=usual_trust()) as client:
        answer = await client.request(method, f"http://{served.address}{path}", content=body)
        assert answer.status_code == status
    assert await served.answers()


async def test_discovery_of_alpyca_finds_the_port_and_nothing_else_is_answered() -> None:
    async with answer_discovery("127.0.0.1", 4711, at=discovery.port):
        found = await asyncio.to_thread(discovery.search_ipv4, 1, 1)
    assert "127.0.0.1:4711" in found


async def end_command(served, asked, phase, message) -> None:
    """Say as the gateway how a command stands."""
    await served.gateway.say(
        frames.CommandState(
            id=asked.id,
            device=asked.device,
            command=asked.command,
            phase=phase,
            message=message,
            who=asked.who,
        )
    )
