"""Clients of others try all that there is: what they hear, and what the robot was sent, is written.

Each connects with a token, subscribes to whatever has a name or a number, publishes velocities to
every device, calls every command and presses STOP everywhere, whether it was offered or not.
"""

from __future__ import annotations

import itertools
import json

import pytest

from talaia.first_completed import until_first
from talaia.wire import frames
from talaia.wire.browser import CommandUpdate, PageCommand

from ..everyone.world import NOW
from .foxglove import foxglove_peer
from .rosbridge.rosbridge_peer import RoslibpyClient
from .sent_messages import sent_for
from .socketio.socketio_peer import (
    FoundingClient,
    NodeClient,
    OldNodeClient,
    PythonClient,
    client_of as socketio_client_of,
)
from .tokens import open_protocol, token_of

pytestmark = pytest.mark.asyncio(loop_scope="module")

REFUSALS = {frames.CommandPhase.REFUSED, frames.CommandPhase.FAILED, frames.CommandPhase.UNKNOWN}
TIMES = itertools.count(NOW, 10**7)
DEVICES = ("base", "power", "camera")
SIGNALS = tuple(f"{device}/{name}" for device in DEVICES for name in ("open", "shut", "words"))
TWIST = {"linear": {"x": 0.9, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": 0.2}}

# Written by hand, see `everyone.world`. An admin lets the driver drive the base, and nobody else
# anything: not even an admin drives by such clients without that.
HEARD = {
    "guest": {"base/open"},
    "driver": {"base/open", "base/shut", "base/words"},
    "admin": set(SIGNALS),
}
COMMANDED = {
    "guest": set(),
    "driver": {("call", "base")},
    "admin": {("call", device) for device in DEVICES},
}
DRIVEN = {
    "guest": set(),
    "driver": {("lease", "base"), ("stop", "base")},
    "admin": {("stop", device) for device in DEVICES},
}

EVERYTHING = {name: COMMANDED[name] | DRIVEN[name] for name in HEARD}


class FoxgloveTries(foxglove_peer.NodeClient):
    """npm's @foxglove/ws-protocol."""

    expected = EVERYTHING

    @classmethod
    async def begin(cls, world, name):
        return await foxglove_peer.client_of(world, name, kind=cls)

    async def try_everything(self) -> None:
        # Channels and services have numbers from 1 on, also those that were not offered.
        for number in range(1, 25):
            await self.call("subscribe", number)
        for topic in ("/v", *(f"/{device}/drive" for device in DEVICES)):
            channel = {"topic": topic, "encoding": "json", "schemaName": "geometry_msgs/Twist"}
            number = await self.call("advertise", channel)
            await self.call("sendMessage", number, "bytes:" + json.dumps(TWIST))
        for number in range(1, 13):
            call = {"serviceId": number, "callId": number, "encoding": "json", "data": "{}"}
            await self.call("sendServiceCallRequest", call)
        # Answered after all of it.
        await self.call("getParameters", [], "all")
        await self.hear("parameterValues")

    async def hear_value(self, value: str) -> None:
        await self.hear("message", lambda said: value in said["data"])


class RoslibpyTries(RoslibpyClient):
    """PyPI's roslibpy."""

    expected = EVERYTHING

    @classmethod
    async def begin(cls, world, name):
        await open_protocol(world.hub, "rosbridge")
        return await cls().connect(world.hub, "agv", await token_of(world.hub, name))

    async def try_everything(self) -> None:
        for address in SIGNALS:
            kind = "std_msgs/String" if address.endswith("words") else "std_msgs/Float64"
            await self.say("subscribe", f"/talaia/{address}", kind)
        for topic in ("/v", *(f"/talaia/{device}/drive" for device in DEVICES)):
            await self.say("publish", topic, "geometry_msgs/Twist", TWIST)
        for device in DEVICES:
            for command in ("turn", "drive/stop"):
                await self.say("call", f"/talaia/{device}/{command}", "std_srvs/Trigger", {})
        await self.say("get_nodes")
        await self.hear("found")

    async def hear_value(self, value: str) -> None:
        await self.hear("message", lambda said: value == str(said[1]["data"]))


class _SocketioTries:
    # There are no commands in this protocol.
    expected = DRIVEN

    @classmethod
    async def begin(cls, world, name):
        return cls(world, name)

    def __init__(self, world, name) -> None:
        self._world, self._name = world, name
        self._clients = []

    @property
    def events(self) -> list:
        return [event for client in self._clients for event in client.events]

    async def try_everything(self) -> None:
        # Which vehicle is meant stands in the address.
        for device in DEVICES:
            client = await socketio_client_of(
                self._world, self._name, self.kind, "/sensedData", vehicle=device
            )
            self._clients.append(client)
            for word in ("w", "stop"):
                await client.ask("/sensedData", "control", word)

    async def hear_value(self, value: str) -> None:
        for client in self._clients:
            await client.hear("sensedData", lambda said: value == str(said["magnitude"]))

    async def __aenter__(self):
        return self

    async def __aexit__(self, *about):
        for client in self._clients:
            await client.__aexit__(*about)


class FoundingTries(_SocketioTries):
    """PyPI's socketIO-client 0.7.2."""

    kind = FoundingClient


class OldNodeTries(_SocketioTries):
    """npm's socket.io-client 2."""

    kind = OldNodeClient


class PythonTries(_SocketioTries):
    """PyPI's python-socketio 5."""

    kind = PythonClient


class NodeTries(_SocketioTries):
    """npm's socket.io-client 4."""

    kind = NodeClient


async def asked_by(page, gateway) -> None:
    """Let the operator's page ask for a command, and wait until the gateway has heard of it."""
    name = f"mark-{next(TIMES)}"
    await page.say(PageCommand(id=name, site="agv", device="camera", command="turn", args={}))
    heard, told = await until_first(
        gateway.hear(frames.CommandRequest, lambda asked: asked.id == name),
        # It is told more before, and by a refusal why.
        page.hear(CommandUpdate, lambda said: said.id == name and said.phase in REFUSALS),
    )
    assert isinstance(heard, frames.CommandRequest), (heard, told, page.heard, gateway.close_code)


CLIENTS = [FoxgloveTries, RoslibpyTries, FoundingTries, OldNodeTries, PythonTries, NodeTries]


@pytest.mark.parametrize("kind", CLIENTS)
@pytest.mark.parametrize("name", HEARD)
async def test_client_hears_and_moves_what_its_person_may_and_nothing_else(
    shared_world, name, kind
) -> None:
    hub, gateway = shared_world.hub, shared_world.gateways["agv"]
    admin = await shared_world.admin()
    driver = str((await hub.people.find_by_name("driver")).id)
    permit = {"person": driver, "site": "agv", "device": "base", "allowed": True}
    assert (await admin.put("/api/client-drivers", json=permit)).status_code == 204
    gateway.heard.clear()
    async with await kind.begin(shared_world, name) as client:
        await client.try_everything()
        # What a page asks for now reaches the gateway after all that was asked before.
        page = await shared_world.page("operator")
        await asked_by(page, gateway)
        await page.close()
        assert sent_for(gateway, name) == kind.expected[name]

        # Of each signal a value of its own.
        now = next(TIMES)
        values = {
            address: f"said-{now}-{at}" if "words" in address else now % 10**9 + at + 0.125
            for at, address in enumerate(SIGNALS)
        }
        await gateway.samples(*((address, now, value) for address, value in values.items()))
        for address in HEARD[name]:
            await client.hear_value(str(values[address]))
        # Whatever comes late has come before this, which everybody hears.
        await gateway.samples(("base/open", now + 1, now % 10**9 + 0.375))
        await client.hear_value(str(now % 10**9 + 0.375))
        rest = json.dumps(client.events)
        assert not [address for address in SIGNALS if str(values[address]) in rest]
