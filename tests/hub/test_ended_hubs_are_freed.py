"""A run of hundreds of hubs in one process holds none that has ended."""

import gc
import weakref

from .conftest import RunningHub


async def test_hub_that_has_ended_is_held_by_nothing(settings) -> None:
    running = RunningHub(settings, None)
    async with running:
        await running.populate()
        assert (await (await running.client("admin")).get("/api/sites")).status_code == 200
    ended = weakref.ref(running.hub)
    del running
    gc.collect()
    assert ended() is None
