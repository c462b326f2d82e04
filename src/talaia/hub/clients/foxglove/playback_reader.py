"""Samples of offered signals out of the history, in their order of time."""

from __future__ import annotations

from heapq import merge
from typing import TYPE_CHECKING

from talaia.hub.clients.signal_subscriptions import ClientSample
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.hub.clients.foxglove.offer import SignalChannel
    from talaia.hub.history.queries.series import Series
    from talaia.hub.ports import History

__all__ = ["PlaybackReader"]

# Points of all channels together that are read at a time: more would hold the hub up.
_MOST_POINTS = 20_000


class PlaybackReader:
    """Reads the past of one site; that it may be seen is for the caller to know."""

    def __init__(self, history: History, site: str) -> None:
        """Read from ``history``."""
        self._history = history
        self._site = site

    async def read_samples(
        self, signals: Sequence[SignalChannel], from_us: int, to_us: int
    ) -> Iterator[ClientSample]:
        """Read a window, both ends included; of very many samples least and greatest stand.

        Raises:
            HistoryError: it cannot be read.

        """
        # Once each: a position is two topics.
        addresses = _addresses_of(signals)
        if not addresses:
            # Nobody has subscribed to anything: time goes on all the same.
            return iter(())
        # Two points for each pixel of a chart.
        width = max(1, _MOST_POINTS // 2 // len(addresses))
        # Of states the least and the greatest say nothing.
        steps = {
            address
            for signal in signals
            if signal.signal.type is SignalType.STATE
            for address in signal.addresses
        }
        found = await self._history.read_series(
            self._site, addresses, from_us, to_us, width=width, steps=steps
        )
        return merge(*map(_samples_of, found), key=lambda sample: sample.time_us)

    async def read_newest(self, signals: Sequence[SignalChannel], at_us: int) -> list[ClientSample]:
        """Read what was newest at a time.

        Raises:
            HistoryError: it cannot be read.

        """
        # A position has several channels, of which each has a newest sample of its own.
        addresses = _addresses_of(signals)
        found = await self._history.last_readings(self._site, addresses, at_us)
        return [
            ClientSample(address, time_us, value, text or None)
            for address, (time_us, value, text) in found.items()
        ]


def _addresses_of(signals: Sequence[SignalChannel]) -> list[str]:
    return list(dict.fromkeys(address for signal in signals for address in signal.addresses))


def _samples_of(series: Series) -> Iterator[ClientSample]:
    # Plain numbers: whoever takes them writes JSON.
    pairs = zip(series.time_us.tolist(), series.value.tolist(), strict=True)
    for at, (time_us, value) in enumerate(pairs):
        yield ClientSample(series.address, time_us, value, series.texts.get(at))
