"""Fixtures of the security tests: the hub with its own stores, and everyone who may ask it."""

from __future__ import annotations

import pytest

from .world import World


@pytest.fixture
async def world(hub_that_stores):
    """Two sites online, one person of each kind, nothing that is made up."""
    async with hub_that_stores() as hub:
        world = World(hub)
        try:
            await world.begin()
            yield world
        finally:
            await world.close()
