"""A real gateway and a real hub: who looks gets each sample as it comes, others change nothing.

How soon that is, is measured in `bench/`. Here batches are told apart by how many samples they
bring: as ever some ten of this robot's, soon two or three.
"""

from __future__ import annotations

import numpy as np
import pytest

from talaia.wire import browser
from talaia.wire.columns import unpack_columns

from .people import Page, page, sign_in
from .stack import Stack, until

pytestmark = pytest.mark.robot
COUNT = "base/count"
RATE = 500
SMALL, TOGETHER = 4.5, 20


async def batches_become_small(looking: Page) -> None:
    """Wait until the page gets few samples at a time, so often that it is no chance."""
    begin = len(looking.got)

    def found() -> bool:
        values = [each for each in looking.got[begin:] if isinstance(each, browser.Values)]
        sizes = [len(unpack_columns(each)) for each in values if not each.age_ms][-TOGETHER:]
        return len(sizes) == TOGETHER and bool(np.mean(sizes) <= SMALL)

    await until(found, what="batches of few samples")


async def test_who_looks_gets_batches_that_are_made_soon_also_after_the_hub_was_away(
    stack: Stack,
) -> None:
    await stack.ready()
    stack.robot.tell(f"count {RATE}")
    cookie = await sign_in(stack, "second")
    async with page(stack, "second", cookie=cookie) as looking:
        await looking.subscribe(COUNT)
        await batches_become_small(looking)
    stack.hub.kill()
    stack.start_hub()
    await stack.hub.says("ready")
    async with page(stack, "second", cookie=await sign_in(stack, "second")) as looking:
        await looking.subscribe(COUNT)
        await batches_become_small(looking)
    stack.robot.tell("quiet")
