"""Two hubs with one bucket: a file is removed by the hub that may keep another under its name."""

from __future__ import annotations

import dataclasses

import pytest
from patience import until_answered

from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.sites.file_removals import FileRemovals

from ..object_stores import BUCKET, KEY_ID, SECRET, ObjectStore
from .two_shards import AGV, EAST, LAB, begun_shards

KEYS = {site: f"recordings/{site}/20260101T120000Z-abcdef.mcap" for site in (AGV, LAB)}


@pytest.fixture
async def store():
    async with ObjectStore() as store:
        yield store


@pytest.fixture
async def shards(divided_settings, tmp_path, store):
    key = tmp_path / "bucket-key"
    key.write_text(f"{KEY_ID}\n{SECRET}\n")
    settings = dataclasses.replace(
        divided_settings,
        files=f"s3://{BUCKET}/files",
        files_endpoint=store.url,
        files_key_file=key,
    )
    async with begun_shards(settings) as begun:
        yield begun


async def test_each_hub_removes_what_is_of_its_own_sites(shards, store, tmp_path) -> None:
    for site, key in KEYS.items():
        whole = tmp_path / site
        whole.write_bytes(b"recorded")
        await shards.main.hub.files.store.keep_file(key, whole)
    assert len(await store.keys()) == 2
    await shards.end(EAST)
    # However it came to be asked here.
    await shards.main.hub.files.store.remove_files(list(KEYS.values()))

    async def is_gone(site: str) -> bool:
        return not [key for key in await store.keys() if key.endswith(KEYS[site])]

    await until_answered(lambda: is_gone(LAB))
    assert not await is_gone(AGV)
    assert await FileRemovals(shards.database).list_keys() == [KEYS[AGV]]
    await shards.start(EAST)
    await until_answered(lambda: is_gone(AGV))


async def test_copies_that_another_hub_uses_outlive_the_start_of_this_one(shards, tmp_path) -> None:
    whole = tmp_path / "whole"
    whole.write_bytes(b"a picture")
    store = shards.east.hub.files.store
    await store.keep_file(KEYS[AGV], whole, near=True)
    async with store.copy_file(KEYS[AGV]) as copy:
        await shards.end(MAIN)
        await shards.start(MAIN)
        assert copy.read_bytes() == b"a picture"
