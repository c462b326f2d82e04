"""The history over HTTP: charts, last values, statistics, outliers, and files to take away.

Long, because all that reads one window is asked and told alike.
"""

from __future__ import annotations

from contextlib import aclosing
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import StreamingResponse

from talaia.hub.anomaly.episode_runner import SCORES
from talaia.hub.api.access import live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.channels import (
    Asked,
    NoChannel,
    asked_channels,
    former_channel,
    may_read,
)
from talaia.hub.api.records.query_params import Time  # noqa: TC001 - FastAPI reads it
from talaia.hub.api.schemas.history_schemas import (
    HistoryAnswer,
    OutlierList,
    OutlierShape,
    ReadingShape,
    StatisticsList,
    StatisticsShape,
    StoredList,
    StoredShape,
    ValueList,
    ValueShape,
)
from talaia.hub.history.errors import HistoryBusy
from talaia.hub.history.queries.arrow_library import require_arrow
from talaia.hub.history.queries.export_formats import MEDIA_TYPES, SUFFIXES, ExportColumn, FileForm
from talaia.hub.history.sensors.sensor_views import StoredSensorKind

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Collection

    from talaia.hub.history.queries.channels import StoredChannel
    from talaia.hub.history.queries.outliers import Outliers
    from talaia.hub.history.queries.series import Series
    from talaia.hub.history.queries.statistics import SampleReading, Statistics
    from talaia.hub.ports import History

__all__ = ["HistoryPages"]

# Channels of one request.
_MOST_SERIES = 100
_BUSY_S = 5  # when to try an export again
_ARROW = MEDIA_TYPES[FileForm.ARROW]
# Without their character set, as OpenAPI names them.
_FILES = [kind.partition(";")[0] for kind in MEDIA_TYPES.values()]
_BYTES: dict[str, object] = {"schema": {"type": "string", "format": "binary"}}
_Addresses = Annotated[list[str], Query(max_length=_MOST_SERIES)]


class HistoryPages:
    """The routes of the history.

    Channels are asked for by their own address (``channel=base/pose.x``) or by that of their
    signal (``signal=base/pose``), which stands for all of its channels; both may be repeated.
    """

    def __init__(self, history: History) -> None:
        """Answer from what is stored."""
        self._history = history

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get(
            "/api/sites/{site}/history",
            response_model=HistoryAnswer,
            responses={200: {"content": {_ARROW: _BYTES}}},
        )(self.window)
        router.get("/api/sites/{site}/last")(self.last)
        router.get("/api/sites/{site}/statistics")(self.statistics)
        router.get("/api/sites/{site}/outliers")(self.outliers)
        router.get("/api/sites/{site}/stored")(self.stored)
        router.get(
            "/api/sites/{site}/export",
            response_class=StreamingResponse,
            responses={200: {"content": dict.fromkeys(_FILES, _BYTES)}},
        )(self.export)
        return router

    async def window(
        self,
        *,
        request: Request,
        from_us: Time,
        to_us: Time,
        channel: _Addresses = [],  # noqa: B006 - FastAPI copies it
        signal: _Addresses = [],  # noqa: B006
        width: Annotated[int, Query(ge=1, le=10_000)] = 1000,
        format: Literal["json", "arrow", ""] = "",  # noqa: A002 - the query's name for it
    ) -> Response:
        """Read a window of some channels: at most two points for each of ``width`` pixels.

        Spikes are kept and gaps named. It comes as JSON, or as an Arrow stream if ``format`` or
        the Accept header says so.
        """
        asked = self._find_channels(request, [*channel, *signal])
        _check_window(from_us, to_us)
        site, addresses = live_of(request).name, [channel.address for channel in asked]
        # Of states the least and the greatest of a pixel say nothing.
        steps = frozenset(channel.address for channel in asked if channel.states)
        found = await self._history.read_series(
            site, addresses, from_us, to_us, width=width, steps=steps
        )
        if format == "arrow" or (not format and _ARROW in request.headers.get("accept", "")):
            require_arrow("Arrow streams")
            # Arrow takes 40 MB of memory, which a hub that is not asked for it need not carry.
            from talaia.hub.history.queries.arrow import series_to_arrow

            return Response(series_to_arrow(found), media_type=_ARROW)
        # Encoded by msgspec: whole columns at a time, and NaN becomes null.
        body = msgspec.json.encode({"series": [_series_json(statistics) for statistics in found]})
        return Response(body, media_type="application/json")

    async def last(
        self,
        request: Request,
        before_us: Time,
        channel: _Addresses = [],  # noqa: B006
        signal: _Addresses = [],  # noqa: B006
    ) -> ValueList:
        """Give the last value of some channels before a time; those that have none are left out."""
        asked = self._find_channels(request, [*channel, *signal])
        addresses = [channel.address for channel in asked]
        # `last` includes its end, "before" does not.
        found = await self._history.last_readings(live_of(request).name, addresses, before_us - 1)
        return ValueList(
            values=[
                ValueShape(address=a, t_us=found[a][0], v=found[a][1], text=text or None)
                for a in addresses
                if a in found
                for text in [found[a][2]]
            ]
        )

    async def statistics(
        self,
        *,
        request: Request,
        from_us: Time,
        to_us: Time,
        channel: _Addresses = [],  # noqa: B006
        signal: _Addresses = [],  # noqa: B006
    ) -> StatisticsList:
        """Sum up a window of some channels."""
        asked = self._find_channels(request, [*channel, *signal])
        _check_window(from_us, to_us)
        addresses = [channel.address for channel in asked]
        found = await self._history.read_statistics(
            live_of(request).name, addresses, from_us, to_us
        )
        return StatisticsList(statistics=[_statistics_schema(statistics) for statistics in found])

    async def outliers(
        self,
        *,
        request: Request,
        from_us: Time,
        to_us: Time,
        channel: _Addresses = [],  # noqa: B006
        signal: _Addresses = [],  # noqa: B006
        k: Annotated[float, Query(ge=0, le=100)] = 1.5,
    ) -> OutlierList:
        """Find the quartiles of a window of some channels, and what lies far outside them.

        All stored samples count, not those that a chart is drawn of; of a window with very many an
        even part, and ``exact`` says so. It takes two or three seconds for each hundred million.
        """
        asked = self._find_channels(request, [*channel, *signal])
        _check_window(from_us, to_us)
        site, found = live_of(request).name, []
        for asked_channel in asked:
            looking = self._history.count_outliers(site, asked_channel.address, from_us, to_us, k=k)
            # Ended here and now, also when who asks has gone: the next one waits for it.
            async with aclosing(looking) as steps:
                async for step in steps:
                    if step is not None:
                        found.append(_outlier_schema(step))
                    elif await request.is_disconnected():
                        # Nobody waits for it any more.
                        return OutlierList(outliers=found)
        return OutlierList(outliers=found)

    async def stored(self, request: Request, former: bool = False) -> StoredList:  # noqa: FBT001, FBT002 - a query's word
        """List what has history and is open to you, also what was renamed or removed since.

        With ``former``, only what the site's description no longer has.
        """
        live, grants = live_of(request), who_of(request).grants
        described = {channel.address for channel in live.channels}
        found = await self._history.list_channels(live.name, described if former else ())
        return StoredList(
            channels=[
                _stored_schema(stored, self._history.kind_of(live.name, stored.address), described)
                for stored in found
                # Scores stand beside their signal, and are not a signal of before.
                if SCORES not in stored.address and may_read(live, grants, stored.address)
            ]
        )

    async def export(
        self,
        *,
        request: Request,
        from_us: Time,
        to_us: Time,
        format: Literal["csv", "parquet", "arrow"],  # noqa: A002 - the query's name for it
        channel: _Addresses = [],  # noqa: B006
        signal: _Addresses = [],  # noqa: B006
        width: Annotated[int, Query(ge=0, le=10_000)] = 0,
    ) -> Response:
        """Take a window of some channels away as a file, streamed.

        One row for each time stamp, one column for each channel. With a ``width``, it holds what
        a chart of so many pixels shows; without, every sample.
        """
        asked = self._find_channels(request, [*channel, *signal])
        _check_window(from_us, to_us)
        site, form = live_of(request).name, FileForm(format)
        columns = [
            ExportColumn(
                channel.address, channel.unit, channel.states, await self._is_text(site, channel)
            )
            for channel in asked
        ]
        pieces = self._history.export_samples(site, columns, from_us, to_us, form=form, width=width)
        try:
            # The first piece tells whether it can be done at all, while there is a status to set.
            first = await anext(pieces, b"")
        except HistoryBusy as error:
            raise ApiProblem(429, "busy", str(error), _BUSY_S) from error
        name = f"{site}-{from_us // 1_000_000}-{to_us // 1_000_000}.{SUFFIXES[form]}"
        return StreamingResponse(
            _rest(first, pieces),
            media_type=MEDIA_TYPES[form],
            headers={"Content-Disposition": f'attachment; filename="{name}"'},
        )

    def _find_channels(self, request: Request, addresses: list[str]) -> list[Asked]:
        if not addresses:
            raise ApiProblem(422, "invalid", "name at least one channel or signal")
        live = live_of(request)

        # Those of detectors stand behind the description's own.
        scores = {channel.address for channel in live.every[len(live.channels) :]}

        def stored(address: str) -> Asked | None:
            if address in scores:
                # Perhaps of a detector that has not written any yet.
                return Asked(address)
            if not self._history.has_channel(live.name, address):
                return None
            return former_channel(address, self._history.kind_of(live.name, address))

        try:
            asked = asked_channels(live, who_of(request).grants, addresses, stored)
        except NoChannel as error:
            raise ApiProblem(404, "unknown", str(error)) from error
        if len(asked) > _MOST_SERIES:
            raise ApiProblem(422, "invalid", f"at most {_MOST_SERIES} channels at once")
        return asked

    async def _is_text(self, site: str, asked: Asked) -> bool:
        if asked.known:
            return asked.text
        # Nobody knows what it was, so its newest sample tells.
        found = await self._history.last_readings(site, [asked.address])
        return any(text for _, _, text in found.values())


def _check_window(from_us: int, to_us: int) -> None:
    if from_us >= to_us:
        raise ApiProblem(422, "invalid", "from_us must be before to_us")


async def _rest(first: bytes, pieces: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    yield first
    async for piece in pieces:
        yield piece


def _stored_schema(
    channel: StoredChannel, kind: StoredSensorKind | None, described: Collection[str]
) -> StoredShape:
    said = StoredSensorKind("", "", "", (), -1) if kind is None else kind
    return StoredShape(
        described=channel.address in described,
        name=said.name,
        unit=said.unit,
        type=said.type,
        states=list(said.states),
        decimals=said.decimals,
        **channel._asdict(),
    )


def _outlier_schema(found: Outliers) -> OutlierShape:
    said = found._asdict()
    return OutlierShape(count=said.pop("outliers"), **said)


def _series_json(series: Series) -> dict[str, object]:
    texts = series.texts
    said: dict[str, object] = {
        "address": series.address,
        "kind": "exact" if series.exact else "minmax",
        "t_us": series.time_us.tolist(),
        "v": series.value.tolist(),
        "gaps": [
            {"from_us": gap.from_us, "to_us": gap.to_us, "reason": gap.reason}
            for gap in series.gaps
        ],
    }
    if texts:
        said["text"] = [texts.get(at, "") for at in range(len(series.time_us))]
    return said


def _statistics_schema(of: Statistics) -> StatisticsShape:
    return StatisticsShape(
        address=of.address,
        count=of.samples,
        numbers=of.numbers,
        low=_reading_schema(of.low),
        high=_reading_schema(of.high),
        mean=of.mean,
        deviation=of.deviation,
        first=_reading_schema(of.first),
        last=_reading_schema(of.last),
        gap_us=of.gap_us,
    )


def _reading_schema(reading: SampleReading | None) -> ReadingShape | None:
    if reading is None:
        return None
    return ReadingShape(t_us=reading.time_us, v=reading.value, text=reading.text or None)
