"""Two hubs, each with some of the sites of one database."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ..databases import database_with_tables
from .two_shards import begun_shards


@pytest.fixture
def divided_settings(settings, tmp_path):
    """The settings of both: one folder, and a database that several may write to."""
    with database_with_tables("postgresql", tmp_path) as url:
        # Named, and read by nobody: the histories of these hubs are in memory.
        servers = tmp_path / "history-servers.yaml"
        yield replace(settings, database_url=url, history_servers=servers)


@pytest.fixture
async def shards(divided_settings):
    """Both, with people and a gateway's key for each site."""
    async with begun_shards(divided_settings) as begun:
        yield begun
