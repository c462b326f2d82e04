"""The address for Alpaca is the hub's that has its site."""

from __future__ import annotations

import dataclasses

import httpx
import pytest
import yaml
from patience import until_answered
from ports import free_port
from shared_trust import usual_trust

from ..clients.tokens import open_protocol, token_of
from .two_shards import AGV, EAST, begun_shards


@pytest.fixture
async def shards(divided_settings, tmp_path):
    """Both hubs, with a file by which the robot of ``east`` is served."""
    said = {
        "address": "127.0.0.1",
        "port": free_port(),
        "site": AGV,
        "token_file": "token",
        "discovery": False,
    }
    (tmp_path / "alpaca.yaml").write_text(yaml.safe_dump(said))
    (tmp_path / "token").write_text("none yet")
    settings = dataclasses.replace(divided_settings, alpaca=tmp_path / "alpaca.yaml")
    async with begun_shards(settings) as begun:
        (tmp_path / "token").write_text(await token_of(begun.main, "operator"))
        begun.url = f"http://127.0.0.1:{said['port']}/management/apiversions"
        yield begun


async def test_the_hub_that_has_the_site_listens(shards) -> None:
    async def answers() -> bool:
        try:
            async with httpx.AsyncClient(verify=usual_trust()) as client:
                return (await client.get(shards.url)).status_code == 200
        except httpx.TransportError:
            return False

    async def is_silent() -> bool:
        return not await answers()

    await open_protocol(shards.main, "alpaca")
    assert not await answers()
    await shards.gateway(AGV)
    await until_answered(answers)
    await shards.end(EAST)
    # The main hub does not take its place: it would say of a robot of others that it is not safe.
    await until_answered(is_silent)
    await shards.start(EAST)
    await until_answered(answers)
