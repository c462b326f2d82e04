"""Every route about a site, and every list of all, as everyone, where two hubs lead the sites."""

from __future__ import annotations

import pytest
import pytest_asyncio

from talaia.hub.sharding.merged_lists import MergedLists

from .everyone.divided_world import begin_divided
from .everyone.routes import RECIPES
from .test_policy_of_routes import differences

# What is about no site is the main shard's, as where sites are not divided.
LED_ON = [route for route in sorted(RECIPES) if "{site}" in route[1] or MergedLists.takes(*route)]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def divided_world(shared_settings):
    async with begin_divided(shared_settings) as world:
        yield world


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize(("method", "path"), LED_ON, ids=lambda each: each)
async def test_route_does_for_everyone_what_its_line_says_at_two_leads(
    divided_world, method, path
) -> None:
    assert await differences(divided_world, method, path) == []
