"""Two hubs at one MQTT broker: each publishes its own sites, and neither ends the other."""

from __future__ import annotations

import dataclasses

import pytest
import yaml
from mosquitto_broker import Broker, mosquitto_program
from sqlalchemy import delete

from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import history_homes

from ..clients.tokens import open_protocol, token_of
from .two_shards import AGV, EAST, LAB, begun_shards

CONFIG = "homeassistant/sensor/t_agv_power/voltage/config"


@pytest.fixture
async def broker(tmp_path):
    mosquitto_program()
    async with Broker(tmp_path) as broker:
        yield broker


@pytest.fixture
async def shards(divided_settings, tmp_path, broker):
    """Both hubs, who publish all of both sites by the rights of the admin."""
    said = {
        "broker": {"host": "127.0.0.1", "port": broker.port, "tls": False},
        "token_file": "token",
        "prefix": "t",
        "every_s": 0.1,
        "home_assistant": "homeassistant",
        "sparkplug": {"group": "g"},
        "sites": {site: {"signals": ["*"], "commands": []} for site in (AGV, LAB)},
    }
    (tmp_path / "mqtt.yaml").write_text(yaml.safe_dump(said))
    (tmp_path / "token").write_text("none yet")
    settings = dataclasses.replace(divided_settings, mqtt=tmp_path / "mqtt.yaml")
    async with begun_shards(settings) as begun:
        (tmp_path / "token").write_text(await token_of(begun.main, "admin"))
        for site in (AGV, LAB):
            await begun.gateway(site)
        await open_protocol(begun.main, "mqtt")
        yield begun


async def test_both_publish_their_sites_and_say_by_themselves_that_they_are_there(
    shards, broker
) -> None:
    async with broker.ear() as ear:
        for topic in ("t/agv/$state", "t/lab/$state", "t/$state", "t/$state-east"):
            await ear.until(lambda topic=topic: ear.holds.get(topic) == b"online")
        # Who looks at a robot of ``east`` sees whether that hub is there.
        await ear.until(lambda: CONFIG in ear.topics())
        assert b'"t/$state-east"' in ear.holds[CONFIG]
        born = {name.split("/")[3] for name, _, _ in ear.heard if "/NBIRTH/" in name}
        assert born == {"talaia", "talaia-east"}
        await shards.end(EAST)
        await ear.until(lambda: ear.holds.get("t/$state-east") == b"offline")
        assert ear.holds["t/$state"] == b"online"


async def test_what_another_hub_publishes_by_now_is_not_cleared(shards, broker) -> None:
    async with broker.ear() as ear:
        # A time in which the main hub has both sites.
        for shard in (MAIN, EAST):
            await shards.end(shard)
        async with shards.database.write() as connection:
            await connection.execute(delete(history_homes))
        await shards.start(MAIN)
        await ear.until(lambda: b'"t/$state"' in ear.holds.get(CONFIG, b""))
        await shards.end(MAIN)
        await HistoryHomes(shards.database).add_home(AGV, EAST)
        await shards.start(EAST)
        await ear.until(lambda: b'"t/$state-east"' in ear.holds.get(CONFIG, b""))
        before = len(ear.heard)
        await shards.start(MAIN)
        await ear.until(lambda: ear.holds.get("t/$state") == b"online")
        later = [name for name, payload, _ in ear.heard[before:] if not payload]
        assert not [name for name in later if "agv" in name], later
        assert {"t/agv/$state", CONFIG} <= ear.topics()
