"""Anomalies that people know, and that nobody is told of while the machine is in some state."""

from __future__ import annotations

import logging
import secrets
from typing import TYPE_CHECKING

import msgspec
from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.sites.detector_state import DetectorState

__all__ = ["MOST_KNOWN", "KnownAnomalies", "KnownAnomaly", "new_key"]

_LOG = logging.getLogger(__name__)
# Of one site; more would be a reason to look at the detector.
MOST_KNOWN = 100
# Where they are kept among what detectors have learned.
_KEPT = ("", "~known")
_FAILS = (SQLAlchemyError, TalaiaError, OSError)


class KnownAnomaly(msgspec.Struct, frozen=True):
    """What a detector tells of is known while a state holds.

    Attributes:
        key: by which it is ended.
        address: of the signal or the group; detector: its word.
        state: address of the state; empty: at all times.
        value: the state's place among its names.
        who: said it; comment: and why.
        since_us: when (µs).

    """

    key: str
    address: str
    detector: str
    state: str
    value: int
    who: str
    comment: str
    since_us: int


class KnownAnomalies:
    """What is known of each site."""

    def __init__(self, learned: DetectorState) -> None:
        """Keep it in ``learned``."""
        self._learned = learned
        # By site; one that is not in it was not read yet.
        self._known: dict[str, list[KnownAnomaly]] = {}

    async def read_site(self, site: str) -> list[KnownAnomaly]:
        """List what is known of a site; it is read once.

        Raises:
            StoreDown: the database does not answer.

        """
        if site not in self._known:
            kept = (await self._learned.states_of(site)).get(_KEPT)
            self._known[site] = (
                [] if kept is None else msgspec.msgpack.decode(kept, type=list[KnownAnomaly])
            )
        return self._known[site]

    async def add_known(self, site: str, known: KnownAnomaly) -> None:
        """Take it that an anomaly is known from now on.

        Raises:
            StoreDown: it could not be kept, and nothing was changed.

        """
        # In place of what was said of the same before.
        others = [one for one in await self.read_site(site) if not _is_same(one, known)]
        await self._save(site, [*others, known])

    async def end_known(self, site: str, key: str) -> KnownAnomaly | None:
        """Tell of it again; None if there is no such entry."""
        before = await self.read_site(site)
        found = next((one for one in before if one.key == key), None)
        if found is not None:
            await self._save(site, [one for one in before if one.key != key])
        return found

    async def read_all(self, sites: list[str]) -> None:
        """Read what is known of these sites, so that it holds from the first sample on."""
        for site in sites:
            try:
                await self.read_site(site)
            except _FAILS as error:
                _LOG.warning("known anomalies of %s are told until they are read: %s", site, error)

    def holding_for(self, live: LiveSite, runner: EpisodeRunner) -> KnownAnomaly | None:
        """Give the entry by which nobody is told of a detector's anomalies now."""
        for one in self._known.get(live.name, ()):
            if (one.address, one.detector) == (runner.address, runner.word) and self.holds(
                live, one
            ):
                return one
        return None

    def over_for(self, live: LiveSite, runners: list[EpisodeRunner]) -> list[EpisodeRunner]:
        """Give those whose anomaly goes on after what it was known for is over."""
        over = [one for one in runners if one.known and self.holding_for(live, one) is None]
        for one in over:
            one.known = ""
        return [one for one in over if one.episodes.began_us >= 0]

    def holds(self, live: LiveSite, known: KnownAnomaly) -> bool:
        """Tell whether the machine is in the state of an entry; what is not known does not hold."""
        if not known.state:
            return True
        for at, channel in enumerate(live.channels):
            if channel.address == known.state:
                # NaN where nothing was heard yet: it is equal to nothing.
                return bool(live.latest.value[at] == known.value)
        return False

    async def _save(self, site: str, known: list[KnownAnomaly]) -> None:
        await self._learned.save_states([(site, *_KEPT, msgspec.msgpack.encode(known))])
        self._known[site] = known


def _is_same(one: KnownAnomaly, other: KnownAnomaly) -> bool:
    mine = (one.address, one.detector, one.state, one.value)
    return mine == (other.address, other.detector, other.state, other.value)


def new_key() -> str:
    """Make a key for an entry."""
    return secrets.token_hex(8)
