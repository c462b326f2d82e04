"""Tells gateways which channels are on somebody's screen, so that those are sent soon."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.wire.frames import SignalSubscription

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from talaia.hub.live.sites import LiveSite, Sites

__all__ = ["SEEN_MS", "WatchedSignals"]

# Who asks for samples more seldom than this (ms) does not see a batch that comes sooner.
SEEN_MS = 50
# A gateway is told no more often than this (s), however pages come and go.
_LEAST_S = 0.1


class _Told(NamedTuple):
    """What a gateway has been told on its link."""

    catalogue: str
    watched: NDArray[np.bool_]  # By place in that list.
    every_ms: int


class WatchedSignals:
    """What each gateway is told. What nobody looks at any more goes on being sent soon for a while.

    On the event loop only. A page that is loaded anew changes nothing so.
    """

    def __init__(
        self,
        sites: Sites,
        watched: Callable[[str], Iterable[tuple[int, NDArray[np.int64]]]],
        linger_s: float,
    ) -> None:
        """Tell gateways of ``sites``.

        Args:
            sites: the sites as they are now.
            watched: gives what is asked for of a site: how often (ms), and numbers in
                `LiveSite.every`, -1 for none.
            linger_s: nobody's channel counts as watched for so long (s).

        """
        self._sites = sites
        self._watched = watched
        self._linger_s = linger_s
        # By site: what its gateway was told on the link that stands; none: nothing yet.
        self._told: dict[str, _Told] = {}
        # By site: since when the gateway counts something as watched that nobody looks at.
        self._idle_s: dict[str, float] = {}
        # By site: looks again at that time; not told again before that other time. All of these
        # are of the loop's clock (s).
        self._timers: dict[str, tuple[asyncio.TimerHandle, float]] = {}
        self._due_s: dict[str, float] = {}

    def link_up(self, site: str) -> None:
        """Begin with a gateway that has been told nothing."""
        self._told.pop(site, None)
        self.update_soon(site)

    def update_soon(self, site: str) -> None:
        """Look at what is watched of a site, once this turn of the loop is over or later."""
        now_s = asyncio.get_running_loop().time()
        self._update_at(site, max(now_s, self._due_s.get(site, now_s)))

    def close(self) -> None:
        """Look no more."""
        for timer, _ in self._timers.values():
            timer.cancel()
        self._timers.clear()

    def _update_at(self, site: str, when_s: float) -> None:
        timer, armed_s = self._timers.get(site, (None, 0.0))
        if timer is not None:
            if armed_s <= when_s:
                return
            timer.cancel()
        loop = asyncio.get_running_loop()
        self._timers[site] = loop.call_at(when_s, self._update_gateway, site), when_s

    def _update_gateway(self, site: str) -> None:
        del self._timers[site]
        live = self._sites.find_site(site)
        if live is None or live.link is None:
            return
        now_s = asyncio.get_running_loop().time()
        (watched, every_ms), told = self._count_watched(live), self._told.get(site)
        if told is None:
            if not watched.any():
                return
        elif told.catalogue == live.catalogue:
            watched = self._keep_idle(site, watched, told.watched, now_s)
            if np.array_equal(watched, told.watched) and every_ms == told.every_ms:
                return
        self._told[site] = _Told(live.catalogue, watched, every_ms)
        self._due_s[site] = now_s + _LEAST_S
        places = np.flatnonzero(watched).astype("<u2").tobytes()
        live.link.send(
            SignalSubscription(catalogue=live.catalogue, channels=places, every_ms=every_ms)
        )

    def _keep_idle(
        self, site: str, watched: NDArray[np.bool_], told: NDArray[np.bool_], now_s: float
    ) -> NDArray[np.bool_]:
        """Give what counts as watched: with what nobody has looked at for a short while only."""
        if not (told & ~watched).any():
            self._idle_s.pop(site, None)
            return watched
        ends_s = self._idle_s.setdefault(site, now_s) + self._linger_s
        if now_s >= ends_s:
            del self._idle_s[site]
            return watched
        self._update_at(site, ends_s)
        return watched | told

    def _count_watched(self, live: LiveSite) -> tuple[NDArray[np.bool_], int]:
        """Tell which channels are looked at, by place in the gateway's list, and how often (ms)."""
        watched, often_ms = np.zeros(len(live.channels), bool), SEEN_MS
        for every_ms, numbers in self._watched(live.name):
            if every_ms > SEEN_MS:
                continue
            # Scores, which stand behind the gateway's own channels, are made here.
            own = numbers[(numbers >= 0) & (numbers < len(watched))]
            watched[own] = True
            if own.size:
                often_ms = min(often_ms, every_ms)
        return watched, often_ms
