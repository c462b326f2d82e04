"""The hub at a real Mosquitto, for accounts of each kind; aiomqtt and mosquitto_sub listen."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import dataclasses
import json
import logging
import socket
import time

import aiomqtt
import pytest
import pytest_asyncio
import yaml
from certificates import Certificates
from mosquitto_broker import Broker, asked_now, mosquitto_program
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from patience import PATIENCE_S, stays

from talaia.clock import SystemClock
from talaia.hub.clients.mqtt.broker_client import connect_broker
from talaia.hub.clients.mqtt.broker_presence import BrokerPresence
from talaia.hub.clients.mqtt.broker_settings import BrokerAddress
from talaia.wire import frames
from talaia.wire.frames import CommandPhase
from talaia.wire.mqtt.topic_tree import TopicTree

from ...conftest import begun
from ...everyone.world import DESCRIPTIONS, NOW
from ..tokens import open_protocol, token_of

pytestmark = pytest.mark.asyncio(loop_scope="module")


class At:
    """A world whose hub is at a broker."""

    def __init__(self, world, broker, folder) -> None:
        self.world, self.broker, self.folder = world, broker, folder

    async def speaks_for(self, name) -> None:
        """Publish by the rights of somebody from now on."""
        await open_protocol(self.world.hub, "mqtt", is_open=False)
        (self.folder / "token").write_text(await token_of(self.world.hub, name))
        async with self.broker.ear() as ear:
            # What is asked of the hub is not the hub's.
            await ear.until(lambda: not [name for name in ear.topics() if "$do" not in name])
            await open_protocol(self.world.hub, "mqtt")
            await ear.until(lambda: ear.holds.get("t/obs/$state") == b"online")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def at(shared_settings, tmp_path_factory):
    mosquitto_program()
    folder = tmp_path_factory.mktemp("mqtt")
    async with Broker(folder) as broker:
        said = {
            "broker": {"host": "127.0.0.1", "port": broker.port, "tls": False},
            "token_file": "token",
            "prefix": "t/obs",
            "every_s": 0.1,
            "home_assistant": "homeassistant",
            # The other site is not named.
            "sites": {"agv": {"signals": ["*"], "commands": ["base/turn"]}},
        }
        (folder / "mqtt.yaml").write_text(yaml.safe_dump(said))
        (folder / "token").write_text("none yet")
        async with begun(dataclasses.replace(shared_settings, mqtt=folder / "mqtt.yaml")) as world:
            gateway = world.gateways["agv"]
            rows = [
                (f"{device}/{name}", NOW, 0.5 if name != "words" else "hello")
                for device in ("base", "power", "camera")
                for name in ("open", "shut", "words")
            ]
            await gateway.samples(*rows)
            await world.gateways["moon"].samples(("rover/open", NOW, 1.0))
            yield At(world, broker, folder)


# What each may see of the site, written by hand: see `everyone.world`.
SEEN = {
    "guest": {"base/open"},
    "driver": {"base/open", "base/shut", "base/words"},
    "admin": {
        f"{device}/{name}"
        for device in ("base", "power", "camera")
        for name in ("open", "shut", "words")
    },
}


@pytest.mark.parametrize("name", SEEN)
async def test_broker_is_told_what_the_account_may_see_and_nothing_else(at, name) -> None:
    async with at.broker.ear() as ear:
        await at.speaks_for(name)
        devices = {seen.split("/")[0] for seen in SEEN[name]}
        values = {f"t/obs/agv/{seen}" for seen in SEEN[name]}
        states = {f"t/obs/agv/{device}/$state" for device in devices}
        wanted = values | states | {"t/obs/$state", "t/obs/agv/$state"}
        await ear.until(lambda: wanted <= ear.topics())
        found = {f"homeassistant/sensor/t_obs_agv_{seen}/config" for seen in SEEN[name]}
        # By hand: who may use the base has a button for its command, who views it one for STOP.
        if name != "guest":
            found |= {"homeassistant/button/t_obs_agv_base/do_turn/config"}
            found |= {
                f"homeassistant/button/t_obs_agv_{device}/stop_software/config"
                for device in devices
            }
        # Now and after all that was said since: of the account before only ends were told.
        assert ear.topics() == wanted | found
        kept = [json.loads(ear.holds[topic]) for topic in sorted(values)]
        assert {value["quality"] for value in kept} <= {"good", "stale"}
        assert not any("moon" in topic or b"moon" in payload for topic, payload, _ in ear.heard)


async def test_value_has_unit_time_and_quality_and_goes_stale_and_lost(at) -> None:
    await at.speaks_for("operator")
    gateway = at.world.gateways["agv"]
    topic = "t/obs/agv/base/open"
    async with at.broker.ear() as ear:
        now_us = SystemClock().wall_ns() // 1000
        await gateway.samples(("base/open", now_us, 2.25), ("base/words", now_us, 'a "b"\n'))
        await ear.until(lambda: ear.value(topic).get("value") == 2.25)
        said = ear.value(topic)
        assert said["quality"] == "good"
        assert said["time"].endswith("Z")
        assert said["unit"] == ""
        await ear.until(lambda: ear.value("t/obs/agv/base/words").get("value") == 'a "b"\n')
        await gateway.say(frames.DeviceState(device="base", reached=False, why="off"))
        await ear.until(lambda: ear.holds.get("t/obs/agv/base/$state") == b"offline")
        await ear.until(lambda: ear.value(topic).get("quality") == "lost")
        await gateway.say(frames.DeviceState(device="base", reached=True))
        await ear.until(lambda: ear.value(topic).get("quality") in {"good", "stale"})
        # Older than its 5 s, and nothing new has come.
        await ear.until(lambda: ear.value(topic).get("quality") == "stale")


async def test_command_passes_the_gate_and_its_end_is_told_with_the_senders_mark(at) -> None:
    await at.speaks_for("driver")
    gateway = at.world.gateways["agv"]
    async with at.broker.ear() as ear:
        await publish(at, "t/obs/agv/base/$do/turn", asked_now(), mark=b"mark 1")
        asked = await gateway.hear(frames.CommandRequest)
        assert asked.who == f"driver by MQTT 127.0.0.1:{at.broker.port}"
        await end_command(gateway, asked, CommandPhase.SUCCEEDED, "turned")
        said, mark = await ear.answer("t/obs/agv/base/$done/turn", "succeeded")
        assert (said["message"], mark) == ("turned", b"mark 1")
    kept = await audit_of(at)
    assert any(
        row["kind"] == "command asked" and "driver by MQTT 127.0.0.1" in row["who"] for row in kept
    )


REFUSED = {
    "of another device": ("power/$do/turn", {}, "not permitted"),
    "of none": ("base/$do/no_such", {}, "not permitted"),
    "without a time": ("base/$do/turn", {"time": None}, "not a command"),
    "that is old": ("base/$do/turn", {"time": -6}, "clocks"),
    "of the future": ("base/$do/turn", {"time": 4}, "clocks"),
    "with an argument that is none": ("base/$do/turn", {"args": {"angle": 9}}, "angle"),
}


@pytest.mark.parametrize("case", REFUSED)
async def test_command_is_refused_with_the_reason(at, case) -> None:
    topic, more, why = REFUSED[case]
    await at.speaks_for("driver")
    said = {"time": time.time()}
    for key, value in more.items():
        said[key] = value if key == "args" or value is None else time.time() + value
    async with at.broker.ear() as ear:
        await publish(at, f"t/obs/agv/{topic}", json.dumps(said))
        answer, _ = await ear.answer(f"t/obs/agv/{topic.replace('$do', '$done')}", "refused")
        assert why in answer["message"]
    await nothing_moves(at)


async def test_retained_command_is_refused_and_logged_once(at, caplog) -> None:
    await at.speaks_for("driver")
    topic = "t/obs/agv/base/$do/turn"
    with caplog.at_level(logging.WARNING):
        async with at.broker.ear() as ear:
            for _ in range(3):
                await publish(at, topic, asked_now(), retain=True)
            # Behind them.
            await publish(at, "t/obs/agv/power/$do/turn", asked_now())
            await ear.answer("t/obs/agv/power/$done/turn", "refused")
        # The broker hands it to whoever subscribes: also a hub that comes back is not moved.
        await at.speaks_for("driver")
        await nothing_moves(at)
    assert len(reports(caplog, "retained")) == 1
    await publish(at, topic, "", retain=True)


async def test_command_that_waits_while_the_hub_is_away_moves_nothing(at) -> None:
    await at.speaks_for("driver")
    await open_protocol(at.world.hub, "mqtt", is_open=False)
    async with at.broker.ear() as ear:
        await ear.until(lambda: not ear.topics())
        await publish(at, "t/obs/agv/base/$do/turn", asked_now(), qos=2)
    await at.speaks_for("driver")
    await nothing_moves(at)


async def test_same_bytes_again_do_it_once(at) -> None:
    await at.speaks_for("driver")
    gateway = at.world.gateways["agv"]
    async with at.broker.ear() as ear:
        payload = asked_now()
        for _ in range(2):
            await publish(at, "t/obs/agv/base/$do/turn", payload)
        asked = await gateway.hear(frames.CommandRequest)
        await ear.answer("t/obs/agv/base/$done/turn", "refused")
        await end_command(gateway, asked, CommandPhase.SUCCEEDED, "")
    await nothing_moves(at)


async def test_account_that_may_not_use_a_device_moves_nothing_by_the_broker(at) -> None:
    await at.speaks_for("guest")
    async with at.broker.ear() as ear:
        await publish(at, "t/obs/agv/base/$do/turn", asked_now())
        answer, _ = await ear.answer("t/obs/agv/base/$done/turn", "refused")
        assert "not permitted" in answer["message"]
    await nothing_moves(at)


async def test_stop_is_pressed_whatever_the_message_says(at) -> None:
    await at.speaks_for("driver")
    gateway = at.world.gateways["agv"]
    async with at.broker.ear() as ear:
        await publish(at, "t/obs/agv/base/$stop", "PRESS")
        asked = await gateway.hear(frames.StopRequest)
        assert asked.device == "base"
        await gateway.say(frames.StopState(device="base", latched=True, id=asked.id))
        await ear.answer("t/obs/agv/base/$done/$stop", "succeeded")
        await gateway.say(frames.StopState(device="base", latched=False))


async def test_messages_of_any_kind_hurt_nothing(at) -> None:
    await at.speaks_for("driver")
    odd = ["", "null", "[]", "\x00", '{"time": 1e999}', '{"time": "2026"}', "{" * 9000]
    async with at.broker.ear() as ear:
        for payload in odd:
            await publish(at, "t/obs/agv/base/$do/turn", payload)
        for topic in ("t/obs/$do/x", "t/obs/agv/base/open", "t/obs/agv/base/$do/turn/more"):
            await publish(at, topic, asked_now())
        await ear.answer("t/obs/agv/base/$done/turn", "refused")
    await nothing_moves(at)


async def test_broker_that_is_killed_is_told_all_again_and_it_is_said_once(at, caplog) -> None:
    await at.speaks_for("admin")
    with caplog.at_level(logging.INFO):
        await at.broker.kill()
        # Several tries fail meanwhile.
        await stays(1.2, lambda: len(reports(caplog, "not reached")) <= 1, "said twice")
        await at.broker.start()
        async with at.broker.ear() as ear:
            await ear.until(lambda: ear.holds.get("t/obs/$state") == b"online")
            await ear.until(lambda: "t/obs/agv/camera/words" in ear.topics())
        # What an admin is shown of it, by then and now.
        assert (await broker_shown(at))["connected"]
    assert len(reports(caplog, "not reached")) == 1
    assert len(reports(caplog, "connected again")) == 1


async def test_admin_is_shown_that_the_broker_is_lost_and_since_when(at) -> None:
    await at.speaks_for("admin")
    before = await broker_shown(at)
    assert (before["connected"], before["why"]) == (True, "")
    assert before["address"] == f"127.0.0.1:{at.broker.port}"
    killed_us = SystemClock().wall_ns() // 1000
    await at.broker.kill()
    lost = await broker_once(at, lambda shown: shown["why"])
    assert not lost["connected"]
    assert lost["since_us"] >= killed_us
    await at.broker.start()
    found = await broker_once(at, lambda shown: shown["connected"])
    assert found["since_us"] > lost["since_us"]


async def test_broker_is_lost_since_the_first_try_that_failed() -> None:
    presence = BrokerPresence()
    presence.name_broker("b:1")
    for now_us in (10, 20, 30):
        presence.report_lost(now_us, f"refused at {now_us}")
    assert (presence.contact.since_us, presence.contact.why) == (10, "refused at 30")
    presence.report_connected(40)
    presence.report_lost(50, "refused")
    assert presence.contact.since_us == 50


async def test_what_the_brokers_access_list_refuses_is_told_once_with_the_reason(tmp_path) -> None:
    rules = ["user talaia", "topic write t/open/#", "topic read t/+/$do/+"]
    accounts = {"talaia": "a secret"}
    (tmp_path / "secret").write_text("a secret")
    refused: list[str] = []
    async with Broker(tmp_path, accounts=accounts, rules=rules) as broker:
        address = BrokerAddress(
            host="127.0.0.1",
            port=broker.port,
            tls=False,
            username="talaia",
            password_file=str(tmp_path / "secret"),
        )
        will = ("t/open/$state", b"offline", True)
        async with connect_broker(address, will=will, report_refusal=refused.append) as client:
            await client.publish("t/open/a", b"1", qos=1)
            assert refused == []
            await client.publish("t/shut/a", b"1", qos=1)
            assert refused == ["publishing (Not authorized)"]
    presence = BrokerPresence()
    assert presence.report_refusal(refused[0])
    assert not presence.report_refusal(refused[0])


async def test_signal_that_is_described_no_more_is_cleared_at_the_broker(at) -> None:
    await at.speaks_for("admin")
    world = at.world
    async with at.broker.ear() as ear:
        await ear.until(lambda: "t/obs/agv/power/shut" in ear.topics())
        # A whole device less.
        first, _, rest = DESCRIPTIONS["agv"].partition("\n  power:")
        less = first + rest[rest.index("\n  camera:") :].replace("  odd_power", "  #odd_power")
        await world.gateways["agv"].close()
        await world.connect("agv", less)
        await ear.until(lambda: not any("power" in topic for topic in ear.topics()))
        assert "t/obs/agv/base/open" in ear.topics()
        await world.gateways["agv"].close()
        await world.connect("agv")
        await ear.until(lambda: "t/obs/agv/power/$state" in ear.topics())


async def test_protocol_that_is_shut_leaves_nothing_at_the_broker(at) -> None:
    await at.speaks_for("admin")
    async with at.broker.ear() as ear:
        await ear.until(lambda: "t/obs/agv/base/open" in ear.topics())
        await open_protocol(at.world.hub, "mqtt", is_open=False)
        await ear.until(lambda: not ear.topics())
        assert ("t/obs/$state", b"offline") in [(topic, said) for topic, said, _ in ear.heard]


async def test_token_that_is_revoked_ends_publishing(at) -> None:
    await at.speaks_for("operator")
    person = await at.world.hub.people.find_by_name("operator")
    async with at.broker.ear() as ear:
        await ear.until(lambda: "t/obs/agv/base/open" in ear.topics())
        tokens = at.world.hub.hub.people.tokens
        for token in await tokens.tokens_of(person.id):
            await tokens.revoke_token(person.id, token.id)
        await ear.until(lambda: not ear.topics())


# paho leaves a socket whose handshake failed to the garbage collector.
@pytest.mark.filterwarnings("ignore:.*SSLSocket:pytest.PytestUnraisableExceptionWarning")
async def test_dead_hub_is_told_by_the_broker_over_tls_that_is_checked(tmp_path) -> None:
    certificates = Certificates(tmp_path)
    tree = TopicTree("t")
    said = {"will": (tree.hub_state, b"offline", True), "report_refusal": print}
    async with Broker(tmp_path, certificates=certificates) as broker:
        address = BrokerAddress(host="127.0.0.1", port=broker.port, ca=str(certificates.ca))
        stranger = BrokerAddress(host="127.0.0.1", port=broker.port)
        with pytest.raises(Exception, match="certificate verify failed"):
            async with connect_broker(stranger, **said):
                pass
        client = connect_broker(address, **said)
        await client.__aenter__()
        await client.publish(tree.hub_state, b"online", qos=1, retain=True)
        heard = await asyncio.create_subprocess_exec(
            mosquitto_program("mosquitto_sub"), "-V", "5", "-h", "127.0.0.1",
            "-p", str(broker.port), "--cafile", str(certificates.ca),
            "-t", tree.hub_state, "-C", "2",
            stdout=asyncio.subprocess.PIPE,
        )  # fmt: skip
        assert (await heard.stdout.readline()) == b"online\n"
        # As a process that is killed: no farewell.
        broken = client._client.socket()
        broken.shutdown(socket.SHUT_RDWR)
        async with asyncio.timeout(PATIENCE_S):
            assert (await heard.stdout.readline()) == b"offline\n"
        await heard.wait()
        with pytest.raises(aiomqtt.MqttError):
            await anext(client.messages)
        await client.__aexit__(None, None, None)
        broken.close()


async def broker_shown(at) -> dict:
    admin = await at.world.kept_client("admin")
    rows = (await admin.get("/api/client-protocols")).json()["protocols"]
    (broker,) = next(row["brokers"] for row in rows if row["protocol"] == "mqtt")
    return broker


async def broker_once(at, holds) -> dict:
    """Give how the broker is shown, once something is true of it."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            shown = await broker_shown(at)
            if holds(shown):
                return shown
            await asyncio.sleep(0.05)


def reports(caplog, words) -> list[str]:
    return [record.message for record in caplog.records if words in record.message]


async def publish(at, topic, payload, *, mark=b"", **options) -> None:
    properties = Properties(PacketTypes.PUBLISH)
    if mark:
        properties.CorrelationData = mark
    async with at.broker.client() as client:
        await client.publish(topic, payload, properties=properties, **{"qos": 1, **options})


async def end_command(gateway, asked, phase, message) -> None:
    await gateway.say(
        frames.CommandState(
            id=asked.id, device=asked.device, command=asked.command, phase=phase, message=message
        )
    )


async def nothing_moves(at) -> None:
    gateway = at.world.gateways["agv"]
    await stays(
        0.4,
        lambda: not any(isinstance(said, frames.CommandRequest) for said in gateway.heard),
        "the robot was asked to do something",
    )


async def audit_of(at) -> list[dict]:
    admin = await at.world.kept_client("admin")
    return (await admin.get("/api/audit")).json()["rows"]
