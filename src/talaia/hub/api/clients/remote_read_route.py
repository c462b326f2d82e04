"""``/clients/prometheus/read``: past values for Prometheus, by its remote read."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request, Response

from talaia.hub.api.access import who_of
from talaia.hub.api.clients.metrics_route import check_metrics_right
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.clients.past_metrics import find_past_channels, series_of_channel
from talaia.hub.history.queries.arrow_library import require_arrow
from talaia.wire.errors import PeerError
from talaia.wire.prometheus.remote_read import decode_read_request, encode_read_response

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import Sites
    from talaia.hub.ports import History
    from talaia.wire.prometheus.remote_read import PastQuery, PastSeries

__all__ = ["RemoteReadRoute"]

_PATH = "/clients/prometheus/read"
# Of a request, unpacked (bytes): a query is a few hundred.
_MOST_REQUEST = 256 * 1024
# Series of one request, and samples of all of them: 18 bytes each.
_MOST_SERIES, _MOST_SAMPLES = 200, 500_000
# Samples of one series.
_MOST_OF_SERIES = 20_000
# The year 2255 (ms), far from what an i64 of microseconds holds.
_LAST_MS = 9 * 10**12
_Label = Annotated[str, Query(max_length=200)]


class RemoteReadRoute:
    """The route that Prometheus asks for what it has not scraped itself."""

    def __init__(self, *, sites: Sites, history: History) -> None:
        """Answer for ``sites`` from their ``history``."""
        self._sites = sites
        self._history = history

    def router(self) -> APIRouter:
        """Give the route."""
        router = APIRouter(route_class=GuardedRoute)
        # No JSON: Protocol Buffers in Snappy, both ways.
        router.post(_PATH, response_class=Response)(self.read)
        return router

    async def read(self, request: Request, job: _Label = "", instance: _Label = "") -> Response:
        """Give the samples of the series that are asked for.

        ``job`` and ``instance`` are labels that all of them get: those by which Prometheus marks
        what it scrapes here, so that both are one series.
        """
        grants = who_of(request).grants
        check_metrics_right(grants, self._sites, "")
        require_arrow("past values for Prometheus")
        labels = {name: said for name, said in (("job", job), ("instance", instance)) if said}
        try:
            queries = decode_read_request(_unpack_request(await request.body()))
        except PeerError as error:
            raise ApiProblem(400, "invalid", error.problem) from error
        results = [await self._answer_query(query, grants, labels) for query in queries]
        # Seconds of arithmetic in the worst case: pages and robots do not wait for it.
        packed = await asyncio.to_thread(_pack_response, results)
        headers = {"Content-Encoding": "snappy"}
        return Response(packed, media_type="application/x-protobuf", headers=headers)

    async def _answer_query(
        self, query: PastQuery, grants: Grants, labels: Mapping[str, str]
    ) -> list[PastSeries]:
        found = find_past_channels(
            self._sites,
            grants=grants,
            matchers=query.matchers,
            more=labels,
            matches_regex=_match_regex,
        )
        if len(found) > _MOST_SERIES:
            raise ApiProblem(
                400,
                "too_many",
                f"{len(found)} series are over {_MOST_SERIES}; name a device or a signal",
            )
        if query.end_ms < query.start_ms or not found:
            return []
        # Two points of each pixel are given at most.
        width = min(_MOST_OF_SERIES, _MOST_SAMPLES // len(found)) // 2
        answered = []
        for site in dict.fromkeys(channel.site for channel in found):
            own = [channel for channel in found if channel.site == site]
            addresses = list(dict.fromkeys(channel.address for channel in own))
            series = await self._history.read_series(
                site,
                addresses,
                max(query.start_ms, 0) * 1000,
                min(query.end_ms, _LAST_MS) * 1000 + 999,
                width=width,
                # Of states the least and the greatest of a pixel say nothing.
                steps={channel.address for channel in own if channel.state >= 0},
            )
            by_address = {one.address: one for one in series}
            answered += [
                series_of_channel(channel, by_address[channel.address])
                for channel in own
                if channel.address in by_address
            ]
        return answered


def _unpack_request(body: bytes) -> bytes:
    """Unpack a block of Snappy.

    Raises:
        PeerError: it is none, or too large.

    """
    size = _unpacked_size(body)
    if size > _MOST_REQUEST:
        raise PeerError(f"a query of {size} bytes is over {_MOST_REQUEST}")
    if not size:
        return b""
    # Arrow takes 40 MB of memory, which a hub that is not asked for past metrics need not carry.
    import pyarrow as pa

    try:
        unpacked: bytes = pa.decompress(body, size, codec="snappy", asbytes=True)
    except pa.ArrowException as error:
        raise PeerError("the query is no block of Snappy") from error
    return unpacked


def _unpacked_size(body: bytes) -> int:
    """Read how large a block of Snappy is when unpacked: a varint that it begins with."""
    size = 0
    for place, byte in enumerate(body[:5]):
        size |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            return size
    raise PeerError("the query is no block of Snappy")


def _pack_response(results: Sequence[Sequence[PastSeries]]) -> bytes:
    import pyarrow as pa

    packed: bytes = pa.compress(encode_read_response(results), codec="snappy", asbytes=True)
    return packed


def _match_regex(pattern: str, values: Sequence[str]) -> list[bool]:
    """Tell which texts match; by RE2, as in Prometheus, so that no pattern takes long."""
    import pyarrow as pa
    import pyarrow.compute as pc

    try:
        fits = pc.match_substring_regex(pa.array(values, pa.string()), f"^(?s:{pattern})$")
    except pa.ArrowException as error:
        raise ApiProblem(400, "invalid", f"{pattern[:100]!r} is no regular expression") from error
    return [bool(fit) for fit in fits.to_pylist()]
