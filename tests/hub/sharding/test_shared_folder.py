"""Two hubs on one data folder: each file is the matter of the hub that has its site."""

# ruff: noqa: D107
from __future__ import annotations

import os
import time
from pathlib import Path

from patience import until_answered

from talaia.hub.history.import_file import FOLDER, READY, Head, ParcelWriter
from talaia.hub.live.observing.alert_folder import TAKEN, AlertFolder
from talaia.hub.live.observing.notice_readers import NoticeReaders
from talaia.hub.live.releases.release_folder import ReleaseFolder
from talaia.hub.live.releases.rollout import Rollout, SiteProgress
from talaia.hub.live.sites import Sites
from talaia.hub.sharding.plan import MAIN
from talaia.model.yaml_text.load import load_site

from ..features.test_alert_notices import DESCRIPTION as OBSERVATORY, notice
from .two_shards import AGV, EAST, LAB, description_of

READERS = (MAIN, EAST)


def leave_parcel(folder: Path, site: str) -> Path:
    head = Head(site=site, file=f"{site}.bag", digest="0" * 64, description=description_of(site))
    with ParcelWriter(folder, head) as writer:
        return writer.publish_file()


async def test_imports_are_taken_by_the_hub_that_has_their_site(shards) -> None:
    folder = shards.settings.data / FOLDER
    await shards.end(MAIN)
    left = {site: leave_parcel(folder, site) for site in (LAB, AGV)}

    async def is_taken(site: str) -> bool:
        return not left[site].exists()

    await until_answered(lambda: is_taken(AGV))
    # East has looked at it, and it is not its own.
    assert left[LAB].exists()
    await shards.start(MAIN)
    await until_answered(lambda: is_taken(LAB))
    assert [site.name for site in shards.main.hub.core.sites] == [LAB]
    assert [site.name for site in shards.east.hub.core.sites] == [AGV]


async def test_an_import_without_a_head_is_set_aside_by_the_main_hub(shards) -> None:
    folder = shards.settings.data / FOLDER
    await shards.end(MAIN)
    folder.mkdir(exist_ok=True)
    (folder / f"a{READY}").write_bytes(b"nothing")
    own = leave_parcel(folder, AGV)

    async def is_taken(path: Path) -> bool:
        return path.name not in os.listdir(folder)

    await until_answered(lambda: is_taken(own))
    assert (folder / f"a{READY}").exists()
    await shards.start(MAIN)
    await until_answered(lambda: is_taken(folder / f"a{READY}"))
    assert (folder / "a.bad").exists()


class Heard:
    """Takes notices, and knows for which hub."""

    def __init__(self) -> None:
        self.notices = []

    async def take_notice(self, live, told) -> None:
        self.notices.append((live.name, told.id.partition("#")[2]))


def reader(folder: Path, shard: str, heard: Heard) -> AlertFolder:
    sites = Sites()
    # Each has an observatory of its own.
    sites.describe_site(
        load_site(OBSERVATORY.replace("site: observatory", f"site: {shard}", 1)), ""
    )
    return AlertFolder(folder, sites, heard, NoticeReaders(shard, READERS))


async def test_a_notice_stays_until_every_hub_has_read_it_and_is_acted_on_once(tmp_path) -> None:
    heard = Heard()
    main, east = (reader(tmp_path, shard, heard) for shard in READERS)
    (tmp_path / "1.xml").write_bytes(notice("first", 1))
    for _ in range(2):
        await main.read_files()
    assert heard.notices == [(MAIN, "first")]
    # A hub that begins anew knows what was read before.
    await reader(tmp_path, MAIN, heard).read_files()
    assert heard.notices == [(MAIN, "first")]
    assert (tmp_path / "1.xml").exists()
    for _ in range(2):
        await east.read_files()
    assert heard.notices == [(MAIN, "first"), (EAST, "first")]
    await main.read_files()
    assert [path.name for path in (tmp_path / TAKEN).iterdir()] == ["1.xml"]
    # Another one of that name is another one, also while a hub has not read the first.
    (tmp_path / "1.xml").write_bytes(notice("second one", 2))
    await main.read_files()
    (tmp_path / "1.xml").write_bytes(notice("the third", 3))
    for folder in (main, east, main):
        await folder.read_files()
    assert heard.notices[2:] == [
        (MAIN, "second one"),
        (MAIN, "the third"),
        (EAST, "the third"),
    ]
    assert not (tmp_path / "1.xml").exists()


async def test_rollouts_of_two_hubs_stand_beside_each_other(shards) -> None:
    folders = [
        ReleaseFolder(shards.settings.data / "releases", hub.hub.core.shard.suffix)
        for hub in (shards.main, shards.east)
    ]
    for folder, site in zip(folders, (LAB, AGV), strict=True):
        folder.write_rollout(
            Rollout(
                id=site, version="1", who="admin", began_us=1, first=1, at_once=1,
                sites={site: SiteProgress()},
            )
        )  # fmt: skip
    for shard in (MAIN, EAST):
        await shards.end(shard)
        await shards.start(shard)
    assert shards.main.hub.releases.rollouts.rollout.id == LAB
    assert shards.east.hub.releases.rollouts.rollout.id == AGV


async def test_what_stands_still_is_ended_by_the_hub_that_has_its_site(shards) -> None:
    # Each looks by itself when it begins.
    await shards.end(EAST)
    old_s = time.time() - 30 * 86_400
    parts = {}
    for site in (AGV, LAB):
        parts[site] = shards.settings.data / "uploads" / site / "a.part"
        parts[site].parent.mkdir(parents=True)
        parts[site].write_bytes(b"the beginning")
        os.utime(parts[site], (old_s, old_s))
    await shards.main.hub.archive.uploads.end_standing_uploads()
    assert [parts[site].exists() for site in (AGV, LAB)] == [True, False]
    await shards.start(EAST)
    await shards.east.hub.archive.uploads.end_standing_uploads()
    assert not parts[AGV].exists()
