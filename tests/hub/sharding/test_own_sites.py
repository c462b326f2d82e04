"""Each hub of two has its own sites alone; what is about another's is sent away."""

from __future__ import annotations

import pytest
import websockets

from talaia.hub.sharding.plan import MAIN
from talaia.wire.gateway_proof import KeyProof, proof_words

from .two_shards import AGV, EAST, LAB


async def names_at(hub) -> list[str]:
    client = await hub.client("operator")
    return [site["site"] for site in (await client.get("/api/sites")).json()]


async def test_each_hub_shows_its_own_sites_alone(shards) -> None:
    for site in (AGV, LAB):
        await shards.gateway(site)
    assert await names_at(shards.main) == [LAB]
    assert await names_at(shards.east) == [AGV]


async def test_after_a_restart_each_knows_its_own_sites_of_before(shards) -> None:
    for site in (AGV, LAB):
        await shards.gateway(site)
    for shard in (MAIN, EAST):
        await shards.end(shard)
    assert await names_at(await shards.start(MAIN)) == [LAB]
    assert await names_at(await shards.start(EAST)) == [AGV]


async def test_a_site_of_another_hub_is_as_one_that_is_not_there(shards) -> None:
    await shards.gateway(AGV)
    client = await shards.main.client("operator")
    answer = await client.get("/api/sites/agv")
    none = await client.get("/api/sites/nowhere")
    assert (answer.status_code, answer.json()) == (none.status_code, none.json())
    assert answer.status_code == 404


@pytest.mark.parametrize("path", ["/gateway/link", "/gateway/media", "/gateway/files"])
async def test_a_gateway_of_another_hubs_site_is_told_to_come_again(shards, path) -> None:
    said = {
        "its key": f"Bearer {shards.keys[AGV]}",
        "no proof yet": proof_words(KeyProof(AGV)),
    }
    for what, words in said.items():
        with pytest.raises(websockets.InvalidStatus) as asked:
            await shards.main.dial(path, {"Authorization": words})
        answer = asked.value.response
        assert (what, answer.status_code) == (what, 503)
        assert "Retry-After" in answer.headers


async def test_a_key_that_nobody_knows_is_refused_by_every_hub(shards) -> None:
    for hub in (shards.main, shards.east):
        with pytest.raises(websockets.InvalidStatus) as asked:
            await hub.dial("/gateway/link", {"Authorization": "Bearer nothing"})
        assert asked.value.response.status_code == 401


async def test_an_admin_is_told_of_each_gateway_by_one_hub(shards) -> None:
    listed = {}
    for hub in (shards.main, shards.east):
        admin = await hub.client("admin")
        await admin.post("/api/gateways/codes", json={"site": "new", "name": ""})
        answer = (await admin.get("/api/gateways")).json()
        listed[hub.shard] = {one["site"] for one in answer["gateways"]}, len(answer["codes"])
    assert listed == {MAIN: ({LAB}, 1), EAST: ({AGV}, 0)}
