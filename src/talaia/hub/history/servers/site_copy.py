"""A site's history is copied block by block while it is written.

How far the copy has come stands in the same transaction as what was copied, so it may be broken
off anywhere, and goes on.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.hub.errors import StoreDown
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.writing.writer_jobs import Adopt, ArrivingChannel

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping, Sequence
    from typing import Any

    from talaia.hub.history.servers.late_descriptions import LateDescriptions
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.history.servers.site_reads import SiteChannel, StoredBlock
    from talaia.hub.history.servers.site_transfer import CopiedChannel, SiteTransfer
    from talaia.hub.history.store import HistoryStore
    from talaia.hub.history.writing.writer_jobs import GapJob
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes

__all__ = ["GATE_S", "SiteCopy", "SiteSource"]

_LOG = logging.getLogger(__name__)
# Blocks copied in one transaction: few, so that what others send does not wait.
_BLOCKS = 32
# Passes while the site is written; each has less to copy than the one before it.
_PASSES = 4
_FEW = 64
# What is left is copied within this time, or what comes has waited too long (s).
GATE_S = 30.0
# Between two questions whether the commit happened (s).
_ASK_S = 1.0
# How often the progress is written down (s).
_REPORT_S = 1.0
# Readings of this long before the last copy are copied once more (µs).
_AGAIN_US = 600_000_000


class _RenamedMeanwhile(Exception):
    """A channel has another address than when it was copied: it begins anew."""


class SiteSource(Protocol):
    """Where a site comes from, as it is read; all of these raise `HistoryAway`."""

    async def list_channels(self, site: str) -> list[SiteChannel]:
        """List a site's channels, with samples or without."""
        ...

    async def list_blocks(self, site: str) -> list[StoredBlock]:
        """List a site's blocks, by channel and number."""
        ...

    async def read_blocks(
        self, blocks: Sequence[StoredBlock]
    ) -> tuple[list[tuple[dict[str, Any], bytes]], list[dict[str, Any]]]:
        """Read blocks with their bodies, and the rollup rows in which they are."""
        ...

    async def read_recent(
        self, channels: Sequence[SiteChannel], after: tuple[int, int]
    ) -> list[dict[str, Any]]:
        """Read some of the readings that views show, after a time and a channel."""
        ...

    async def read_sensors(self, site: str) -> list[dict[str, Any]]:
        """Read what a site's sensors are, and were."""
        ...

    async def read_runs(self, site: str) -> dict[str, list[tuple[int, int]]]:
        """Give what of each boot is stored."""
        ...

    async def read_gaps(self, site: str) -> list[GapJob]:
        """Give what of each boot is lost, as it is written."""
        ...


class _Left(NamedTuple):
    """What is still to be copied."""

    channels: list[SiteChannel]
    blocks: list[StoredBlock]
    copied: Mapping[int, CopiedChannel]
    all_blocks: int


class SiteCopy:
    """The copy of one move, from wherever the one before it ended.

    Attributes:
        home: what is asked for, and how far it is.

    """

    def __init__(
        self,
        places: SitePlaces,
        descriptions: LateDescriptions,
        homes: HistoryHomes,
        home: HistoryHome,
    ) -> None:
        """Copy what ``home`` says."""
        self._places, self._descriptions = places, descriptions
        self._homes = homes
        self.home = home
        # When its progress was written down last (s, of the loop).
        self._reported_s = 0.0
        # The newest reading that was copied.
        self._read_us = -(2**62)

    async def erase_left(self) -> None:
        """Erase what was left behind, once nobody reads there any more."""
        home = self.home
        # Whoever began to read there before the change reads to the end.
        await self._places.wait_unread(home.site, home.erase_at)
        await self._places.store_named(home.erase_at).transfer.erase_site(home.site)
        await self._homes.finish_erasing(home.site, home.erase_at)
        self.home = home._replace(erase_at="")
        _LOG.info("nothing of the history of %s is left at %s", home.site, home.erase_at)

    async def begin_copy(self, target: HistoryStore) -> None:
        """Erase what is there unless it is of this move: its home is elsewhere."""
        site = self.home.site
        copied = await target.transfer.read_copied(site)
        if not copied and await target.transfer.list_blocks(site):
            # The accounts may be of a backup from before it moved there: it may be the newer one.
            raise HistoryError(
                f"{self.home.moving_to!r} has a history of {site} that is no copy",
                "restore the accounts and all servers as they were at one time",
            )
        if {channel.move for channel in copied.values()} != {self.home.move}:
            await target.transfer.erase_site(site)
        await self._descriptions.describe_moved(site, target)

    @asynccontextmanager
    async def explain_failures(self, target: HistoryStore) -> AsyncIterator[None]:
        """Say in words why a copy to ``target`` ends; one that cannot go on is erased.

        Raises:
            HistoryError: its last part took too long, or channels were renamed within it.

        """
        site = self.home.site
        try:
            yield
        except TimeoutError:
            raise HistoryError(
                f"the last of {site} took longer than {GATE_S:g} s", "it is tried again"
            ) from None
        except _RenamedMeanwhile:
            await target.transfer.erase_site(site)
            raise HistoryError(
                f"channels of {site} have other names now", "it is copied anew"
            ) from None

    async def copy_hot(self, source: SiteSource, target: SiteTransfer) -> None:
        """Copy until little is left; all goes on meanwhile."""
        for _ in range(_PASSES):
            if await self._copy_left(source, target) < _FEW:
                break

    async def copy_more(self, source: SiteSource, target: SiteTransfer) -> None:
        """Copy what has become blocks since, and the readings that views show."""
        await self._copy_left(source, target)
        await self._copy_recent(source, target)

    async def copy_rest(self, source: SiteSource, store: HistoryStore) -> None:
        """Copy all that is left: all of it is in blocks, and nothing of the site is written."""
        site, target = self.home.site, store.transfer
        while await self._copy_left(source, target):
            pass
        await self._copy_recent(source, target)
        await self._descriptions.describe_moved(site, store)
        await target.adopt_sensors(site, await source.read_sensors(site))
        await target.adopt_runs(site, await source.read_runs(site), await source.read_gaps(site))

    async def _copy_left(self, source: SiteSource, target: SiteTransfer) -> int:
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
            await target.adopt_rows(Adopt(self.home.site, self.home.move, channels, rows, wanted))
            done = left.all_blocks - len(left.blocks) + first + len(blocks)
            self.home = self.home._replace(done_blocks=done, all_blocks=left.all_blocks)
            await self._report_progress()
        return len(left.blocks)

    async def _report_progress(self) -> None:
        # For people, who read no faster.
        now_s = asyncio.get_running_loop().time()
        if now_s - self._reported_s >= _REPORT_S:
            self._reported_s = now_s
            await self._homes.report_progress(self.home)

    async def _list_left(self, source: SiteSource, target: SiteTransfer) -> _Left:
        site = self.home.site
        channels = await source.list_channels(site)
        copied = await target.read_copied(site)
        for channel in channels:
            if channel.id in copied and copied[channel.id].address != channel.address:
                raise _RenamedMeanwhile
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
            await target.adopt_rows(Adopt(self.home.site, self.home.move, new))

    async def _copy_recent(self, source: SiteSource, target: SiteTransfer) -> None:
        """Copy the readings that views show, from a while before those that were copied."""
        site, move = self.home.site, self.home.move
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

    async def switch_home(self, *, led_by: str = "") -> None:
        """Let the site be where it moves; see `HistoryHomes.switch_home`.

        Raises:
            HistoryError: it was asked for otherwise meanwhile, or the hold was taken back.

        """
        home = self.home
        try:
            done = await self._homes.switch_home(home, led_by=led_by)
        except StoreDown:
            done = await self._ask_switched()
        if not done:
            raise HistoryError(f"the move of {home.site} was asked for otherwise meanwhile")
        self._places.home_of[home.site] = home.moving_to
        self.home = home._replace(
            server=home.moving_to, moving_to="", move="", hold="", erase_at=home.server
        )
        _LOG.info("the history of %s is at %s from now on", home.site, home.moving_to)

    async def _ask_switched(self) -> bool:
        """Find out whether a commit happened of which nothing was heard; until then all waits."""
        while True:
            try:
                found = await self._homes.find_home(self.home.site)
            except StoreDown:
                await asyncio.sleep(_ASK_S)
            else:
                return found is not None and found.server == self.home.moving_to
