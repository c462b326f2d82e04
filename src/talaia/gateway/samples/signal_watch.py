"""What somebody at the hub looks at now: it is read from the robot soon, and goes out soon."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

import numpy as np

from talaia.gateway.samples.flush_pace import SOON_S

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from talaia.wire.frames import SignalSubscription

__all__ = ["PacedBatches", "PacedReader", "SignalWatch"]

# Who wants a sample no more often than this (ms) does not see whether it was read a little sooner:
# the robot is read this often (s) for them.
_SEEN_MS, _SEEN_TURN_S = 50, 0.010


class PacedBatches(Protocol):
    """Makes batches of samples; see `Batcher`."""

    def watch_channels(
        self, catalogue: str, places: NDArray[np.uint16], every_s: float = 0.0
    ) -> bool:
        """Have these channels go out soon from here on, and no others; False: of another list."""
        ...


class PacedReader(Protocol):
    """Reads the robot; see `MultiAdapter`."""

    def watch_devices(self, devices: frozenset[str], turn_s: float) -> None:
        """Read what these devices say so often (s), and that of others as ever."""
        ...


class SignalWatch:
    """Event loop only. Begins with nobody who looks, and so does each link."""

    def __init__(
        self,
        *,
        batches: PacedBatches,
        reader: PacedReader,
        listed: Callable[[], tuple[str, Sequence[str]]],
    ) -> None:
        """Hurry these two; ``listed`` gives the name of the channel list that counts, and it."""
        self._batches = batches
        self._reader = reader
        self._listed = listed

    def subscribe(self, asked: SignalSubscription) -> None:
        """Hurry what the hub says is looked at, and nothing else."""
        # The peer's bytes: half a number is left out, as is what is not in the list.
        places = np.frombuffer(asked.channels, "<u2", len(asked.channels) // 2)
        _, addresses = self._listed()
        places = places[places < len(addresses)]
        # The hub speaks of a list that counts no more, and will speak of the new one soon.
        if self._batches.watch_channels(asked.catalogue, places, asked.every_ms / 1000):
            named = {addresses[place].partition("/")[0] for place in places.tolist()}
            turn_s = SOON_S if asked.every_ms < _SEEN_MS else _SEEN_TURN_S
            self._reader.watch_devices(frozenset(named), turn_s)

    def link_lost(self) -> None:
        """Hurry no more: nobody can look."""
        catalogue, _ = self._listed()
        self._batches.watch_channels(catalogue, np.empty(0, np.uint16))
        self._reader.watch_devices(frozenset(), math.inf)
