"""Takes what gateways report on observations: kept first, acknowledged after that, each once."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.hub.errors import StoreDown
from talaia.model.observing.states import RequestState
from talaia.wire.frames import ObservationAck

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.hub.live.site_state import SiteLink
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.observations import ObservationStore
    from talaia.hub.store.observing.request_rows import EndedRequest
    from talaia.hub.store.observing.request_store import RequestStore
    from talaia.wire.frames import ObservationUpdate

__all__ = ["ObservationIntake", "RequestNews"]

_LOG = logging.getLogger(__name__)
# A night makes a few thousand; a gateway with more has them one link later.
_MOST_WAITING = 20_000
# Reports in one transaction.
_AT_ONCE = 200
_RETRY_S = 2.0
# Between looks for requests whose windows are over (s).
_EXPIRE_S = 30.0


class RequestNews(Protocol):
    """Whoever tells people what has become of requests."""

    def requests_moved(self, site: str, requests: Sequence[int]) -> None:
        """Requests of a site have changed; never waits."""
        ...


class _Waiting(NamedTuple):
    site: str
    link: SiteLink
    report: ObservationUpdate


class ObservationIntake:
    """Writes reports down in the order in which they come."""

    def __init__(
        self,
        *,
        observations: ObservationStore,
        requests: RequestStore,
        news: RequestNews,
        resend: Callable[[str], None],
        deliver: Callable[[], None],
        audit: Audit,
    ) -> None:
        """Keep reports in ``observations``; oddities go to the log of the hub, ``audit``.

        ``resend`` is called with a site whose requests its gateway has to be sent anew, and
        ``deliver`` when there may be something to tell those who asked.
        """
        self._observations = observations
        self._requests = requests
        self._news = news
        self._resend = resend
        self._deliver = deliver
        self._audit = audit
        self._waiting: deque[_Waiting] = deque()
        self._wake = asyncio.Event()

    def handle_report(self, live: LiveSite, report: ObservationUpdate) -> None:
        """Take a report; its gateway is told when it is kept."""
        if live.link is None:
            return
        if len(self._waiting) >= _MOST_WAITING:
            # Passed over alone, a later one would acknowledge it: all come again on a new link.
            live.link.dismiss_gateway("the hub cannot keep what was observed; try again later")
            return
        self._waiting.append(_Waiting(live.name, live.link, report))
        self._wake.set()

    async def run(self) -> None:
        """Keep reports until cancelled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._waiting:
                try:
                    await self._store_some()
                except StoreDown as error:
                    _LOG.warning("reports on observations wait: %s", error)
                    await asyncio.sleep(_RETRY_S)

    async def expire_requests(self) -> None:
        """End requests whose windows are over, until cancelled."""
        while True:
            try:
                while ended := await self._requests.expire_requests():
                    self._tell_ended(ended)
            except StoreDown as error:
                _LOG.warning("requests whose windows are over wait: %s", error)
            await asyncio.sleep(_EXPIRE_S)

    async def _store_some(self) -> None:
        first = self._waiting[0]
        some: list[ObservationUpdate] = []
        for waiting in self._waiting:
            # Of one link: the acknowledgement of another would say nothing of these.
            if waiting.link is not first.link or len(some) == _AT_ONCE:
                break
            some.append(waiting.report)
        stored = await self._observations.store_reports(first.site, some)
        # Only now: whoever is cancelled before has written nothing, or all of it once more.
        for _ in some:
            self._waiting.popleft()
        first.link.send(ObservationAck(number=max(report.number for report in some)))
        for oddity in stored.oddities:
            self._audit.append_record(
                "observation odd",
                site=first.site,
                message=oddity,
                good=False,
                source="gateway",
            )
        # Those that have ended are told of below.
        ended = {one.id for one in stored.ended}
        self._news.requests_moved(first.site, sorted(set(stored.changed) - ended))
        if stored.again:
            self._resend(first.site)
        self._tell_ended(stored.ended, source="gateway")

    def _tell_ended(self, ended: Sequence[EndedRequest], source: str = "hub") -> None:
        for one in ended:
            self._audit.append_record(
                f"request {one.state.value.lower().replace('_', ' ')}",
                site=one.site,
                message=f"{one.id} of {one.proposal}: {one.why}",
                good=one.state is RequestState.COMPLETED,
                source=source,
            )
        if ended:
            self._deliver()
        moved: dict[str, list[int]] = {}
        for one in ended:
            moved.setdefault(one.site, []).append(one.id)
        for site, numbers in moved.items():
            self._news.requests_moved(site, numbers)
