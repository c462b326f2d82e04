"""A site's history goes from one server to another while it is written.

Blocks are copied while all goes on, until little is left. Then nothing of the site is written for
a moment: what is in memory is made blocks, the last are copied, and one commit in the accounts'
database says where the site is from now on. What was left behind is erased after it. Killed at any
point, it is taken up by what is written: up to that commit the old place has all, after it the new
one, and how far the copy has come stands in the same transaction as what was copied.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.errors import StoreDown
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.writing.writer_jobs import Adopt, ArrivingChannel

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.history.servers.late_descriptions import LateDescriptions
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.history.servers.site_transfer import (
        CopiedChannel,
        SiteChannel,
        SiteTransfer,
        StoredBlock,
    )
    from talaia.hub.history.store import HistoryStore
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes

__all__ = ["SiteMove"]

_LOG = logging.getLogger(__name__)
# Blocks copied in one transaction: few, so that what others send does not wait.
_BLOCKS = 32
# Passes while the site is written; each has less to copy than the one before it.
_PASSES = 4
_FEW = 64
# Between two questions whether the commit happened (s).
_ASK_S = 1.0
# What is left is copied within this time, or what comes has waited too long (s).
_GATE_S = 30.0
# How often the progress is written down (s).
_REPORT_S = 1.0
# Readings of this long before the last copy are copied once more (µs).
_AGAIN_US = 600_000_000


class _Renamed(Exception):
    """A channel has another address than when it was copied: it begins anew."""


class _Left(NamedTuple):
    """What is still to be copied."""

    channels: list[SiteChannel]
    blocks: list[StoredBlock]
    copied: Mapping[int, CopiedChannel]
    all_blocks: int


class SiteMove:
    """One move, from wherever the one before it ended."""

    def __init__(
        self,
        places: SitePlaces,
        descriptions: LateDescriptions,
        homes: HistoryHomes,
        home: HistoryHome,
    ) -> None:
        """Do what ``home`` says."""
        self._places, self._descriptions = places, descriptions
        self._homes = homes
        self._home = home
        # When its progress was written down last (s, of the loop).
        self._reported_s = 0.0
        # The newest reading that was copied.
        self._read_us = -(2**62)

    async def run(self) -> None:
        """Move the site, and erase what is left behind.

        Raises:
            HistoryError: a server is away; it goes on later.
            StoreDown: the accounts' database is.

        """
        home = self._home
        if home.erase_at and home.erase_at != home.moving_to:
            await self._erase_left()
        if home.moving_to:
            await self._copy_and_switch()
            if self._home.erase_at:
                await self._erase_left()
        # What is too old may be dropped again.
        for store in self._places.open_stores():
            store.transfer.hold_retention(home.site, held=False)

    async def _erase_left(self) -> None:
        home = self._home
        # Whoever began to read there before the change reads to the end.
        await self._places.wait_unread(home.site, home.erase_at)
        await self._places.store_named(home.erase_at).transfer.erase_site(home.site)
        await self._homes.finish_erasing(home.site, home.erase_at)
        self._home = home._replace(erase_at="")
        _LOG.info("nothing of the history of %s is left at %s", home.site, home.erase_at)

    async def _copy_and_switch(self) -> None:
        home = self._home
        source = self._places.store_named(home.server)
        target = self._places.store_named(home.moving_to)
        await self._begin_copy(target)
        try:
            for _ in range(_PASSES):
                if await self._copy_left(source.transfer, target.transfer) < _FEW:
                    break
            # Of what is in memory the most becomes blocks before anybody waits.
            await source.transfer.seal_site(home.site)
            await self._copy_left(source.transfer, target.transfer)
            await self._copy_recent(source.transfer, target.transfer)
            async with self._places.hold_writes(home.site):
                async with asyncio.timeout(_GATE_S):
                    await self._copy_rest(source.transfer, target)
                await self._switch_home()
            await target.transfer.clear_copied(home.site)
        except TimeoutError:
            raise HistoryError(
                f"the last of {home.site} took longer than {_GATE_S:g} s", "it is tried again"
            ) from None
        except _Renamed:
            await target.transfer.erase_site(home.site)
            raise HistoryError(
                f"channels of {home.site} have other names now", "it is copied anew"
            ) from None

    async def _begin_copy(self, target: HistoryStore) -> None:
        """Erase what is there unless it is of this move: its home is elsewhere."""
        site = self._home.site
        copied = await target.transfer.read_copied(site)
        if not copied and await target.transfer.list_blocks(site):
            # The accounts may be of a backup from before it moved there: it may be the newer one.
            raise HistoryError(
                f"{self._home.moving_to!r} has a history of {site} that is no copy",
                "restore the accounts and all servers as they were at one time",
            )
        if {channel.move for channel in copied.values()} != {self._home.move}:
            await target.transfer.erase_site(site)
        await self._descriptions.describe_moved(site, target)

    async def _copy_left(self, source: SiteTransfer, target: SiteTransfer) -> int:
        """Copy the blocks that are not there yet; give how many there were."""
        left = await self._list_left(source, target)
        by_id = {channel.id: channel for channel in left.channels}
        await self._adopt_channels(target, left)
        for first in range(0, len(left.blocks), _BLOCKS):
            blocks = left.blocks[first : first + _BLOCKS]
            rows, rollups = await source.read_blocks(blocks)
            # One that was dropped meanwhile has no body any more.
            come = {row["channel_id"]: row["id"] for row, _ in rows}
            channels = [
                ArrivingChannel(number, by_id[number].address, by_id[number].since_us, block)
                for number, block in come.items()
            ]
            wanted = [row for row in rollups if row["channel_id"] in come]
            await target.adopt_rows(Adopt(self._home.site, self._home.move, channels, rows, wanted))
            done = left.all_blocks - len(left.blocks) + first + len(blocks)
            self._home = self._home._replace(done_blocks=done, all_blocks=left.all_blocks)
            await self._report_progress()
        return len(left.blocks)

    async def _report_progress(self) -> None:
        # For people, who read no faster.
        now_s = asyncio.get_running_loop().time()
        if now_s - self._reported_s >= _REPORT_S:
            self._reported_s = now_s
            await self._homes.report_progress(self._home)

    async def _list_left(self, source: SiteTransfer, target: SiteTransfer) -> _Left:
        site = self._home.site
        channels = await source.list_channels(site)
        copied = await target.read_copied(site)
        for channel in channels:
            if channel.id in copied and copied[channel.id].address != channel.address:
                raise _Renamed
        every = await source.list_blocks(site)
        blocks = [
            block
            for block in every
            if block.channel not in copied or block.id > copied[block.channel].block
        ]
        return _Left(channels, blocks, copied, len(every))

    async def _adopt_channels(self, target: SiteTransfer, left: _Left) -> None:
        """Make a place for channels of which nothing has come."""
        new = [
            ArrivingChannel(channel.id, channel.address, channel.since_us, 0)
            for channel in left.channels
            if channel.id not in left.copied
        ]
        if new:
            await target.adopt_rows(Adopt(self._home.site, self._home.move, new))

    async def _copy_recent(self, source: SiteTransfer, target: SiteTransfer) -> None:
        """Copy the readings that views show, from a while before those that were copied."""
        site, move = self._home.site, self._home.move
        channels = await source.list_channels(site)
        copied = await target.read_copied(site)
        after = (max(self._read_us - _AGAIN_US, -(2**62)), 0)
        while rows := await source.read_recent(channels, after):
            known = {row["channel_id"] for row in rows}
            arriving = [
                ArrivingChannel(
                    channel.id, channel.address, channel.since_us, copied[channel.id].block
                )
                for channel in channels
                if channel.id in known and channel.id in copied
            ]
            wanted = [row for row in rows if row["channel_id"] in copied]
            await target.adopt_rows(Adopt(site, move, arriving, recent=wanted))
            after = (rows[-1]["time_us"], rows[-1]["channel_id"])
            self._read_us = max(self._read_us, after[0])

    async def _copy_rest(self, source: SiteTransfer, store: HistoryStore) -> None:
        """Copy all that is left; nothing of the site is written meanwhile."""
        site, target = self._home.site, store.transfer
        await source.seal_all(site)
        while await self._copy_left(source, target):
            pass
        await self._copy_recent(source, target)
        await self._descriptions.describe_moved(site, store)
        await target.adopt_sensors(site, await source.read_sensors(site))
        await target.adopt_runs(site, await source.read_runs(site), await source.read_gaps(site))

    async def _switch_home(self) -> None:
        home = self._home
        try:
            done = await self._homes.switch_home(home)
        except StoreDown:
            done = await self._ask_switched()
        if not done:
            raise HistoryError(f"the move of {home.site} was asked for otherwise meanwhile")
        self._places.home_of[home.site] = home.moving_to
        self._home = home._replace(
            server=home.moving_to, moving_to="", move="", erase_at=home.server
        )
        _LOG.info("the history of %s is at %s from now on", home.site, home.moving_to)

    async def _ask_switched(self) -> bool:
        """Find out whether a commit happened of which nothing was heard; until then all waits."""
        while True:
            try:
                found = await self._homes.find_home(self._home.site)
            except StoreDown:
                await asyncio.sleep(_ASK_S)
            else:
                return found is not None and found.server == self._home.moving_to
