"""What of all that shards say one page is to hear, and which sites they have told it of."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from talaia.hub.sharding.page_frames import read_told
from talaia.hub.sharding.plan import MAIN

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from talaia.hub.sharding.page_frames import ToldAbout
    from talaia.hub.sharding.page_subscriptions import PageSubscriptions

__all__ = ["KnownSites", "PageNews"]


class KnownSites:
    """What shards have told of their sites, to any page of this process.

    Attributes:
        shards: by site, the shard that told of it last.
        catalogues: by site, what names its description.

    """

    def __init__(self) -> None:
        """Know none."""
        self.shards: dict[str, str] = {}
        self.catalogues: dict[str, str] = {}


class PageNews:
    """What shards say to one page.

    Attributes:
        greeted: the page has heard the greeting.

    """

    def __init__(
        self,
        known: KnownSites,
        subscriptions: PageSubscriptions,
        shards: Iterable[str],
        *,
        site_came: Callable[[str, str], None],
    ) -> None:
        """Note in ``known`` what is told of sites; ``subscriptions`` are the page's.

        ``site_came`` hears of a site and the shard that has it now, when that first tells of it.
        """
        self._site_came = site_came
        self._known = known
        self._subscriptions = subscriptions
        # By shard, the sites that it has told this page of.
        self._sites: dict[str, set[str]] = {shard: set() for shard in shards}
        self.greeted = False
        # Which shard has told the page that its session is over.
        self._ended_by = ""

    def passes(self, shard: str, data: bytes | str) -> bool:
        """Tell whether the page is to hear a message of a shard; asked twice, it says the same."""
        told = read_told(data, numbered=bool(self._subscriptions.moved))
        if told is None:
            return True
        match told.t:
            case "greeting":
                return shard == MAIN and not self.greeted
            case "pong" | "session":
                # The main shard's word: it knows the same sessions.
                return shard == MAIN
            case "ended":
                self._ended_by = self._ended_by or shard
                return self._ended_by == shard
            case "values" | "subscribed":
                return self._subscriptions.is_from(told.sub, shard)
            case "site":
                self._remember_site(shard, told)
                return True
            case _:
                return True

    def sites_of(self, shard: str) -> Iterator[tuple[str, str]]:
        """Give the sites that the page knows of a shard, and what names their descriptions."""
        for site in sorted(self._sites[shard]):
            # Another one has told of it since.
            if self._known.shards.get(site) == shard:
                yield site, self._known.catalogues.get(site, "")

    def _remember_site(self, shard: str, told: ToldAbout) -> None:
        # One text for all pages: there may be thousands of sites.
        site = sys.intern(told.site)
        self._known.shards[site] = shard
        if told.catalogue:
            self._known.catalogues[site] = told.catalogue
        if site in self._sites[shard]:
            return
        for sites in self._sites.values():
            sites.discard(site)
        self._sites[shard].add(site)
        # Though none has told of it before: what is asked of it may have gone to one that had it.
        self._site_came(site, shard)
