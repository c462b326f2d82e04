"""The hub as an edge node of Sparkplug B at a real Mosquitto, read and asked by pysparkplug."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import dataclasses
import json
import time

import pytest
import pytest_asyncio
import yaml
from mosquitto_broker import Broker, mosquitto_program
from patience import PATIENCE_S, stays

from talaia.clock import SystemClock
from talaia.wire import frames
from talaia.wire.frames import CommandPhase

from ...conftest import begun
from ...everyone.world import NOW
from ..tokens import open_protocol, token_of

pysparkplug = pytest.importorskip(
    "pysparkplug", reason="requirements/judges.txt is not installed; run make setup"
)
DataType, Metric, Topic = pysparkplug.DataType, pysparkplug.Metric, pysparkplug.Topic
MessageType = pysparkplug.MessageType

pytestmark = pytest.mark.asyncio(loop_scope="module")

PAYLOADS = {
    MessageType.NBIRTH: pysparkplug.NBirth,
    MessageType.NDEATH: pysparkplug.NDeath,
    MessageType.DBIRTH: pysparkplug.DBirth,
    MessageType.DDEATH: pysparkplug.DDeath,
    MessageType.DDATA: pysparkplug.DData,
}
BASE = "agv.base"


class Host:
    """A host application: what it has heard, each with its kind, device and payload."""

    def __init__(self, client) -> None:
        self.client = client
        self.heard = []
        self._births = {}
        self._news = asyncio.Condition()

    async def read(self) -> None:
        async for message in self.client.messages:
            topic = Topic.from_str(str(message.topic))
            if topic.message_type not in PAYLOADS:
                continue
            assert not message.retain
            assert (topic.group_id, topic.edge_node_id) == ("plant", "talaia")
            read = PAYLOADS[topic.message_type]
            payload = read.decode(message.payload, birth=self._births.get(topic.device_id))
            if topic.message_type in {MessageType.NBIRTH, MessageType.DBIRTH}:
                self._births[topic.device_id] = payload
            async with self._news:
                self.heard.append((topic.message_type, topic.device_id, payload))
                self._news.notify_all()

    async def hear(self, kind, device=None, where=lambda payload: True):
        """Wait for a message, of those heard already or still to come; all before it are gone."""

        def found():
            for at, (said, of, payload) in enumerate(self.heard):
                if said is kind and of == device and where(payload):
                    return at + 1
            return 0

        async with asyncio.timeout(PATIENCE_S), self._news:
            await self._news.wait_for(found)
            payload = self.heard[found() - 1][2]
            del self.heard[: found()]
            return payload

    async def write(self, kind, *metrics, device=None, time_ms=None, retain=False) -> None:
        said = {MessageType.NCMD: pysparkplug.NCmd, MessageType.DCMD: pysparkplug.DCmd}[kind]
        now_ms = round(time.time() * 1000) if time_ms is None else time_ms
        written = [
            Metric(timestamp=now_ms, name=name, datatype=datatype, value=value)
            for name, datatype, value in metrics
        ]
        payload = said(timestamp=now_ms, metrics=tuple(written)).encode(include_dtypes=True)
        topic = Topic("plant", kind, "talaia", device)
        await self.client.publish(str(topic), payload, qos=1, retain=retain)


def values(payload) -> dict:
    return {metric.name: metric.value for metric in payload.metrics}


class At:
    """A world whose hub is an edge node."""

    def __init__(self, world, broker, folder) -> None:
        self.world, self.broker, self.folder = world, broker, folder

    async def speaks_for(self, host, name) -> dict:
        """Publish by the rights of somebody; give the births by device."""
        await open_protocol(self.world.hub, "mqtt", is_open=False)
        (self.folder / "token").write_text(await token_of(self.world.hub, name))
        await open_protocol(self.world.hub, "mqtt")
        return {None: await host.hear(MessageType.NBIRTH)}


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def at(shared_settings, tmp_path_factory):
    mosquitto_program()
    folder = tmp_path_factory.mktemp("sparkplug")
    async with Broker(folder) as broker:
        said = {
            "broker": {"host": "127.0.0.1", "port": broker.port, "tls": False},
            "token_file": "token",
            "every_s": 0.1,
            "sparkplug": {"group": "plant"},
            "sites": {"agv": {"signals": ["*"], "commands": ["base/turn"]}},
        }
        (folder / "mqtt.yaml").write_text(yaml.safe_dump(said))
        (folder / "token").write_text("none yet")
        async with begun(dataclasses.replace(shared_settings, mqtt=folder / "mqtt.yaml")) as world:
            rows = [("base/open", NOW, 0.5), ("base/words", NOW, "hello"), ("power/open", NOW, 1.5)]
            await world.gateways["agv"].samples(*rows)
            yield At(world, broker, folder)


@pytest_asyncio.fixture(loop_scope="module")
async def host(at):
    async with at.broker.client() as client:
        # As MQTT 5 tells what was retained and what was only published to be.
        await client.subscribe("spBv1.0/#", qos=1)
        host = Host(client)
        reading = asyncio.create_task(host.read())
        yield host
        reading.cancel()
        found = await asyncio.gather(reading, return_exceptions=True)
        assert isinstance(found[0], asyncio.CancelledError), found


async def test_edge_node_and_its_devices_are_born_with_types_and_values_and_numbers_rise(
    at, host
) -> None:
    node = (await at.speaks_for(host, "driver"))[None]
    assert node.seq == 0
    (birth,) = (metric for metric in node.metrics if metric.name == "bdSeq")
    assert birth.datatype is DataType.INT64
    assert values(node)["Node Control/Rebirth"] is False
    device = await host.hear(MessageType.DBIRTH, BASE)
    assert device.seq == 1
    found = {metric.name: (metric.datatype, metric.value) for metric in device.metrics}
    assert found["open"] == (DataType.DOUBLE, 0.5)
    assert found["words"] == (DataType.STRING, "hello")
    # Nothing was heard of it yet.
    assert found["shut"] == (DataType.DOUBLE, None)
    assert found["Device Control/turn"] == (DataType.BOOLEAN, False)
    assert found["Device Control/Stop"] == (DataType.BOOLEAN, False)
    aliases = [metric.alias for metric in device.metrics if metric.alias is not None]
    assert len(set(aliases)) == len(aliases) == 4
    # What another device has is not for this account.
    now_us = SystemClock().wall_ns() // 1000
    await at.world.gateways["agv"].samples(("base/open", now_us, 2.5), ("power/open", now_us, 9.0))
    data = await host.hear(MessageType.DDATA, BASE, lambda said: "open" in values(said))
    assert data.seq >= 2
    assert values(data) == {"open": 2.5}
    assert [metric.timestamp for metric in data.metrics] == [now_us // 1000]
    await at.world.gateways["agv"].samples(("base/open", now_us + 1, 3.5))
    after = await host.hear(MessageType.DDATA, BASE, lambda said: "open" in values(said))
    # Whatever was told between them has a number of its own.
    assert 0 < after.seq - data.seq <= 2
    assert not any(of and of != BASE for _, of, _ in host.heard)


async def test_host_that_asks_for_rebirth_gets_it_under_the_number_of_the_last_will(
    at, host
) -> None:
    node = (await at.speaks_for(host, "driver"))[None]
    await host.hear(MessageType.DBIRTH, BASE)
    await host.write(MessageType.NCMD, ("Node Control/Rebirth", DataType.BOOLEAN, True))
    again = await host.hear(MessageType.NBIRTH)
    assert again.seq == 0
    assert values(again)["bdSeq"] == values(node)["bdSeq"]
    assert (await host.hear(MessageType.DBIRTH, BASE)).seq == 1


async def test_device_that_is_not_reached_dies_and_is_born_again(at, host) -> None:
    await at.speaks_for(host, "operator")
    await host.hear(MessageType.DBIRTH, BASE)
    gateway = at.world.gateways["agv"]
    await gateway.say(frames.DeviceState(device="base", reached=False, why="off"))
    await host.hear(MessageType.DDEATH, BASE)
    await gateway.say(frames.DeviceState(device="base", reached=True))
    await host.hear(MessageType.DBIRTH, BASE)


async def test_command_passes_the_gate_and_its_end_is_a_metric(at, host) -> None:
    await at.speaks_for(host, "driver")
    await host.hear(MessageType.DBIRTH, BASE)
    gateway = at.world.gateways["agv"]
    await host.write(MessageType.DCMD, ("Device Control/turn", DataType.BOOLEAN, True), device=BASE)
    asked = await gateway.hear(frames.CommandRequest)
    assert (asked.device, asked.command) == ("base", "turn")
    assert asked.who == f"driver by Sparkplug 127.0.0.1:{at.broker.port}"
    await gateway.say(
        frames.CommandState(
            id=asked.id,
            device="base",
            command="turn",
            phase=CommandPhase.SUCCEEDED,
            message="turned",
        )
    )
    assert (await answer(host, "succeeded"))["message"] == "turned"
    await host.write(
        MessageType.DCMD, ("Device Control/Stop", DataType.BOOLEAN, True), device=BASE, time_ms=1
    )
    pressed = await gateway.hear(frames.StopRequest)
    await gateway.say(frames.StopState(device="base", latched=True, id=pressed.id))
    assert (await answer(host, "succeeded"))["command"] == "Stop"
    await gateway.say(frames.StopState(device="base", latched=False))


REFUSED = {
    "an old one": ("Device Control/turn", True, -6000, "clocks"),
    "one from ahead": ("Device Control/turn", True, 4000, "clocks"),
    "a value": ("open", 1.0, 0, "cannot be written"),
    "what is not permitted": ("Device Control/open", True, 0, "cannot be written"),
}


@pytest.mark.parametrize("case", REFUSED)
async def test_command_is_refused_with_the_reason(at, host, case) -> None:
    name, value, late_ms, why = REFUSED[case]
    await at.speaks_for(host, "driver")
    await host.hear(MessageType.DBIRTH, BASE)
    kind = DataType.BOOLEAN if value is True else DataType.DOUBLE
    time_ms = round(time.time() * 1000) + late_ms
    await host.write(MessageType.DCMD, (name, kind, value), device=BASE, time_ms=time_ms)
    assert why in (await answer(host, "refused"))["message"]
    await nothing_moves(at)


async def test_retained_command_moves_nothing(at, host) -> None:
    await at.speaks_for(host, "driver")
    await host.hear(MessageType.DBIRTH, BASE)
    wanted = ("Device Control/turn", DataType.BOOLEAN, True)
    await host.write(MessageType.DCMD, wanted, device=BASE, retain=True)
    # Also on a switch that goes back, and on what is no payload at all.
    await host.write(
        MessageType.DCMD, ("Device Control/turn", DataType.BOOLEAN, False), device=BASE
    )
    await host.client.publish("spBv1.0/plant/DCMD/talaia/agv.base", b"\xff\xff", qos=1)
    await nothing_moves(at)
    await host.client.publish("spBv1.0/plant/DCMD/talaia/agv.base", b"", qos=1, retain=True)


async def test_account_that_may_only_look_has_nothing_to_write(at, host) -> None:
    await at.speaks_for(host, "guest")
    device = await host.hear(MessageType.DBIRTH, BASE)
    assert set(values(device)) == {"open"}
    await host.write(MessageType.DCMD, ("Device Control/turn", DataType.BOOLEAN, True), device=BASE)
    await nothing_moves(at)


async def test_edge_node_dies_by_its_own_word_and_by_the_brokers(at, host) -> None:
    first = values((await at.speaks_for(host, "driver"))[None])["bdSeq"]
    await open_protocol(at.world.hub, "mqtt", is_open=False)
    death = await host.hear(MessageType.NDEATH)
    assert death.bd_seq_metric.value == first
    await open_protocol(at.world.hub, "mqtt")
    second = values(await host.hear(MessageType.NBIRTH))["bdSeq"]
    assert second == (first + 1) % 256
    # Somebody of its name ends its connection: as far as the broker knows, it is dead.
    async with at.broker.client(identifier="talaia-sparkplug"):
        death = await host.hear(MessageType.NDEATH)
        assert death.bd_seq_metric.value == second
    third = values(await host.hear(MessageType.NBIRTH))["bdSeq"]
    assert third != second


async def answer(host, phase) -> dict:
    name = "Device Control/Answer"

    def told(payload) -> bool:
        said = values(payload).get(name)
        return bool(said) and json.loads(said)["phase"] == phase

    return json.loads(values(await host.hear(MessageType.DDATA, BASE, told))[name])


async def nothing_moves(at) -> None:
    gateway = at.world.gateways["agv"]
    await stays(
        0.4,
        lambda: not any(isinstance(said, frames.CommandRequest) for said in gateway.heard),
        "the robot was asked to do something",
    )
