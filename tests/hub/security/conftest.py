"""Fixtures of the security tests: the hub with its own stores, and everyone who may ask it."""

from __future__ import annotations

from contextlib import asynccontextmanager

import pytest
import pytest_asyncio

from ..conftest import RunningHub  # noqa: TID252 - of the same tests
from .world import World


@pytest.fixture
async def world(settings):
    """Two sites online, one person of each kind, nothing that is made up."""
    async with begun(settings) as world:
        yield world


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def shared_world(shared_settings):
    """The same, for many tests of a file; they run in the file's event loop."""
    async with begun(shared_settings) as world:
        yield world


@asynccontextmanager
async def begun(settings):
    async with RunningHub(settings, None) as hub:
        world = World(hub)
        try:
            await world.begin()
            yield world
        finally:
            await world.close()
