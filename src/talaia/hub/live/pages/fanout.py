"""Live samples to every browser that asked; the work is shared by those who asked the same."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.clock import MS
from talaia.hub.live.pages.conflate import conflate
from talaia.hub.live.pages.outbox import values_of
from talaia.hub.live.pages.subscriptions import select_channels
from talaia.hub.live.pages.watched_signals import WatchedSignals
from talaia.wire.browser import Subscribed
from talaia.wire.columns import Columns, join_columns

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.hub.live.pages.outbox import Frame
    from talaia.hub.live.pages.page_connections import Browser
    from talaia.hub.live.pages.subscriptions import Selection
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.wire.browser import Subscribe, Values

__all__ = ["Fanout"]

# What gathers between two sendings is thinned when it is more than this.
_MOST_GATHERED = 20_000


@dataclass(eq=False, slots=True)
class _Group:
    """Those who asked for the same channels of a site at the same pace."""

    # The site's short name.
    site: str
    selection: Selection
    # At most one sending in so many ms; 0: each batch as it comes.
    every_ms: int
    # By page and its own number of the subscription, with what it asked for.
    members: dict[tuple[Browser, int], Subscribe] = field(default_factory=dict)
    # What has gathered since the last sending; empty with `every_ms` 0.
    pieces: list[Columns] = field(default_factory=list)
    # Samples in `pieces`.
    gathered: int = 0
    # Not before this moment is sent again (monotonic).
    due_ns: int = 0
    # Set while something waits for `due_ns`.
    timer: asyncio.TimerHandle | None = None


class Fanout:
    """Subscriptions of all browsers, and the way of a batch to them.

    Attributes:
        watched: tells gateways what is on a screen.

    """

    def __init__(self, sites: Sites, clock: Clock, linger_s: float) -> None:
        """Find sites in ``sites``; ``clock`` paces the sending; see `WatchedSignals`."""
        self._sites = sites
        self._clock = clock
        # By site, then by rate and channels: pages that ask alike are encoded for once.
        self._groups: dict[str, dict[tuple[int, tuple[str, ...]], _Group]] = {}
        # By page and its number of the subscription.
        self._of: dict[tuple[Browser, int], _Group] = {}
        self.watched = WatchedSignals(sites, self._asked_channels, linger_s)

    def subscribe(self, browser: Browser, asked: Subscribe) -> None:
        """Start a subscription, or replace the one with its number, and send what is known."""
        live = self._sites.find_site(asked.site)
        if live is None:
            return
        self.unsubscribe(browser, asked.sub)
        selection = select_channels(
            asked.channels, live.description, live.every, browser.who.grants
        )
        group = self._group(live, selection, asked.every_ms)
        group.members[browser, asked.sub] = asked
        self._of[browser, asked.sub] = group
        self.watched.update_soon(asked.site)
        browser.send_message(Subscribed(sub=asked.sub, refused=list(selection.refused)))
        # The outbox asks by it for newest values when they go out.
        browser.known = self.known
        # The newest value of every channel, before any sample that comes from now on.
        browser.owe(asked.sub, (selection.channels >= 0).nonzero()[0].tolist(), first=True)

    def unsubscribe(self, browser: Browser, sub: int) -> None:
        """End a subscription; one that is not there is no matter."""
        group = self._of.pop((browser, sub), None)
        browser.forget(sub)
        if group is None:
            return
        del group.members[browser, sub]
        if not group.members:
            # Otherwise it would send for a group that is not there any more.
            if group.timer is not None:
                group.timer.cancel()
            of_site = self._groups[group.site]
            del of_site[group.every_ms, group.selection.key]
            self.watched.update_soon(group.site)

    def leave(self, browser: Browser) -> None:
        """End every subscription of a browser."""
        for member in [key for key in self._of if key[0] is browser]:
            self.unsubscribe(*member)

    def held(self, browser: Browser) -> tuple[int, int]:
        """Count a browser's subscriptions, and the channels in all of them."""
        sizes = [
            len(group.members[member].channels)
            for member, group in self._of.items()
            if member[0] is browser
        ]
        return len(sizes), sum(sizes)

    def redescribe(self, live: LiveSite) -> None:
        """Start every subscription of a site anew, after its channels changed."""
        # A list first: ending and starting change the groups that it comes from.
        members = [
            (member[0], asked)
            for group in list(self._groups.get(live.name, {}).values())
            for member, asked in group.members.items()
        ]
        # All end before one starts: a group that still has a member is joined as it is, with the
        # channel numbers of the description before.
        for browser, asked in members:
            self.unsubscribe(browser, asked.sub)
        for browser, asked in members:
            self.subscribe(browser, asked)

    def publish(self, live: LiveSite, columns: Columns) -> None:
        """Hand a live batch to everyone who asked for any of it."""
        for group in self._groups.get(live.name, {}).values():
            picked = group.selection.of(columns)
            if not len(picked):
                continue
            if group.every_ms == 0:
                _send(group, picked)
            else:
                self._gather(group, picked)

    def _asked_channels(self, site: str) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Give how often each group of a site is sent something (ms), and its channels."""
        for group in self._groups.get(site, {}).values():
            yield group.every_ms, group.selection.channels

    def _gather(self, group: _Group, picked: Columns) -> None:
        group.pieces.append(picked)
        group.gathered += len(picked)
        if group.gathered > _MOST_GATHERED:
            # Bounded by its channels: at most four samples of each stay.
            group.pieces = [conflate(join_columns(group.pieces))]
            group.gathered = len(group.pieces[0])
        if group.timer is not None:
            return
        wait_ns = group.due_ns - self._clock.monotonic_ns()
        # Nothing was sent for a whole interval: this goes at once.
        if wait_ns <= 0:
            self._flush(group)
        else:
            group.timer = asyncio.get_running_loop().call_later(wait_ns / 1e9, self._flush, group)

    def _flush(self, group: _Group) -> None:
        group.timer = None
        group.due_ns = self._clock.monotonic_ns() + group.every_ms * MS
        pieces, group.pieces, group.gathered = group.pieces, [], 0
        _send(group, conflate(join_columns(pieces)))

    def _group(self, live: LiveSite, selection: Selection, every_ms: int) -> _Group:
        of_site = self._groups.setdefault(live.name, {})
        key = (every_ms, selection.key)
        group = of_site.get(key)
        if group is None:
            group = of_site[key] = _Group(live.name, selection, every_ms)
        return group

    def known(self, browser: Browser, sub: int, places: list[int]) -> list[Values]:
        """Give the newest values of channels of a subscription (places in its list), and ages."""
        group = self._of.get((browser, sub))
        live = None if group is None else self._sites.find_site(group.site)
        if group is None or live is None:
            return []
        at = np.array(places, np.int64)
        numbers = group.selection.channels[at]
        # Those that were refused have no number.
        at, numbers = at[numbers >= 0], numbers[numbers >= 0]
        columns, ages = live.latest.values_of(numbers, self._clock.monotonic_ns())
        # Numbered by the places in the page's own list.
        columns = Columns(
            at[columns.channel].astype("<u2"), columns.time_us, columns.value, columns.texts
        )
        told, begin = [], 0
        for message in values_of(sub, columns):
            # Channels are packed as two bytes each.
            end = begin + len(message.channel) // 2
            told.append(msgspec.structs.replace(message, age_ms=ages[begin:end]))
            begin = end
        return told

    def publish_known(self, live: LiveSite, channels: NDArray[np.uint16]) -> None:
        """Tell everyone who asked for any of these channels its newest value, and its age."""
        for group in self._groups.get(live.name, {}).values():
            places = group.selection.place[channels]
            owed = places[places >= 0].tolist()
            if not owed:
                continue
            if group.pieces:
                # What gathered is older, and goes before it.
                if group.timer is not None:
                    group.timer.cancel()
                self._flush(group)
            for browser, sub in group.members:
                browser.owe(sub, owed)


def _send(group: _Group, columns: Columns) -> None:
    """Encode once for all who use the same number, and put it in each outbox."""
    if not len(columns):
        return
    # By the page's number of the subscription and its form.
    encoded: dict[tuple[int, str], Frame | None] = {}
    for browser, sub in group.members:
        key = (sub, browser.form)
        if key not in encoded:
            messages = values_of(sub, columns)
            # More than one message is rare and huge: the outbox cuts it by itself.
            encoded[key] = browser.encode(messages[0]) if len(messages) == 1 else None
        browser.values(sub, columns, encoded[key])
