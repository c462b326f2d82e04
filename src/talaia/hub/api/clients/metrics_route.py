"""``/metrics``: figures for Prometheus, as OpenMetrics or in its own older text form."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request, Response
from prometheus_client import CollectorRegistry, ProcessCollector
from prometheus_client.exposition import choose_encoder

from talaia import __version__
from talaia.clock import SECOND
from talaia.hub.api.access import who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.auth.permissions import ANY, Right
from talaia.hub.clients.catalog import CLIENT_PROTOCOLS
from talaia.hub.clients.site_metrics import HubFigures, ScrapeRequest, collect_metrics
from talaia.hub.cluster.peers import SILENT_S

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from prometheus_client.core import Metric

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.cluster.peers import HubNotice
    from talaia.hub.files.ports import FileStore
    from talaia.hub.live.alarms.alarm_state import LiveAlarm
    from talaia.hub.live.pages.page_connections import Browsers
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import ClusterSeat

__all__ = ["MetricsRoute", "check_metrics_right"]

# A scrape that names more is a mistake, and each is held against every signal.
_MOST_PATTERNS = 50


def check_metrics_right(grants: Grants, sites: Iterable[LiveSite], site: str) -> None:
    """Let an account pass that may have the metrics of a site, or (empty) of any.

    Raises:
        ApiProblem: 403 it may not.

    """
    names = [site] if site else [ANY, *(live.name for live in sites)]
    if not any(grants.has_right(Right.METRICS, name) for name in names):
        raise ApiProblem(403, "forbidden", "this account has no right `metrics`; see Admin")


class _Figures:
    """Hands figures that were collected already to the library's registry."""

    def __init__(self, figures: list[Metric]) -> None:
        self._figures = figures

    def collect(self) -> Iterator[Metric]:
        """Give them."""
        yield from self._figures


class MetricsRoute:
    """The route that Prometheus scrapes, with a token of an account that has ``metrics``."""

    def __init__(
        self,
        *,
        protocols: OpenProtocols,
        sites: Sites,
        browsers: Browsers,
        alarms_of: Callable[[str], Iterable[LiveAlarm]],
        clock: Clock,
        files: FileStore,
        seat: ClusterSeat | None = None,
    ) -> None:
        """All of it is where figures come from."""
        self._files = files
        self._seat = seat
        self._protocols = protocols
        self._sites = sites
        self._browsers = browsers
        self._alarms_of = alarms_of
        self._clock = clock

    def router(self) -> APIRouter:
        """Give the route."""
        router = APIRouter(route_class=GuardedRoute)
        # No JSON: Prometheus's own text, in the form that it asks for.
        router.get("/metrics", response_class=Response)(self.scrape)
        return router

    async def scrape(
        self,
        request: Request,
        site: Annotated[str, Query(max_length=64)] = "",
        signal: Annotated[list[str] | None, Query(max_length=_MOST_PATTERNS)] = None,
    ) -> Response:
        """Give the figures of now, of one site or of all that the account may have.

        ``signal`` is a pattern of addresses (``base/*``), once for each; without it the signals of
        the first page are given.
        """
        who = who_of(request)
        check_metrics_right(who.grants, self._sites, site)
        registry = CollectorRegistry()
        if who.grants.has_right(Right.METRICS, ANY):
            # Memory, processor time and descriptors of the hub, by their usual names.
            ProcessCollector(registry=registry)
        figures = collect_metrics(
            HubFigures(
                __version__,
                sum(1 for _ in self._browsers),
                {name: self._protocols.count_connected(name) for name in CLIENT_PROTOCOLS},
                self._list_hubs(),
                not self._files.trouble if self._files.remote else None,
            ),
            self._sites,
            grants=who.grants,
            asked=ScrapeRequest(site, tuple(signal or ())),
            alarms_of=self._alarms_of,
            now_ns=self._clock.monotonic_ns(),
        )
        registry.register(_Figures(list(figures)))
        encoder, content_type = choose_encoder(request.headers.get("accept", ""))
        return Response(encoder(registry), media_type=content_type)

    def _list_hubs(self) -> Sequence[HubNotice]:
        """List the hubs that are there now; of one that is gone nothing is shown."""
        seat, now_ns = self._seat, self._clock.monotonic_ns()
        if seat is None:
            return ()
        heard = [
            notice
            for notice, heard_ns in seat.heard_hubs()
            if now_ns - heard_ns <= SILENT_S * SECOND
        ]
        return [seat.own_notice(), *heard]
