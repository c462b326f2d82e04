"""The hub with its own history: what came over the link is read back over HTTP, also later."""

import numpy as np

from talaia.wire.browser import Subscribe, Values
from talaia.wire.frames import Ack

NOW = 1_700_000_000_000_000


async def test_samples_are_read_back_and_survive_the_hub(hub_that_stores) -> None:
    async with hub_that_stores() as hub:
        await hub.populate()
        key = hub.keys["agv"]
        gateway = await hub.gateway()
        await gateway.hello()
        await gateway.samples(*[("base/speed", NOW + at * 1000, at / 100) for at in range(200)])
        await gateway.hear(Ack, lambda ack: ack.below == 200)
    async with hub_that_stores() as hub:
        hub.keys["agv"] = key
        client = await hub.client("guest")
        query = {"channel": "base/speed", "from_us": NOW, "to_us": NOW + 1_000_000, "width": 500}
        series = (await client.get("/api/sites/agv/history", params=query)).json()["series"][0]
        assert series["v"] == [at / 100 for at in range(200)]
        assert series["t_us"] == [NOW + at * 1000 for at in range(200)]
        # The site is known and its last value is shown with its true age, though it is away.
        site = (await client.get("/api/sites")).json()[0]
        assert (site["online"], site["stale"]) == (False, site["signals"])
        page = await hub.page("guest")
        await page.say(Subscribe(sub=1, site="agv", channels=["base/speed"]))
        known = await page.hear(Values)
        assert np.frombuffer(known.value).tolist() == [1.99]
        assert known.age_ms[0] > 1_000_000
        gateway = await hub.gateway()
        assert (await gateway.hello()).acked == 200
