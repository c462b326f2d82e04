"""Raw topics of past moments: what recordings hold, as trees and as bytes."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from typing import TYPE_CHECKING, Annotated

import msgspec
from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.query_params import STILL, Time
from talaia.hub.api.records.recorded_bytes import BytesAnswer, RecordedBytes
from talaia.hub.api.records.recorded_schemas import (
    MomentShape,
    RecordedMessageShape,
    RecordedTopicShape,
    StretchShape,
)
from talaia.hub.auth.permissions import seen_camera
from talaia.hub.live.taps.cloud_thinning import CLOUD_TYPE, thin_cloud
from talaia.hub.live.taps.message_tree import tree_reader
from talaia.hub.live.taps.type_texts import MessageUnreadable
from talaia.wire.browser import MAX_RAW, MAX_TREE
from talaia.wire.frames import TapSchema

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.clock import Clock
    from talaia.hub.live.recorded.recorded_topics import FoundTopic, ReadStretch, RecordedTopics
    from talaia.hub.live.recorded.recording_index import RecordedMessage
    from talaia.hub.store.audit import Audit

__all__ = ["RecordedTopicPages"]

# Of one question: topics, µs of a stretch, bytes of messages, messages as trees.
_MOST_TOPICS, _MOST_SPAN_US = 64, 60_000_000
_MOST_BYTES, _MOST_TREES = 8 * 1024 * 1024, 600
# Bytes of messages that are made trees for one question: a tree takes the hub more than a copy.
_MOST_TREE_BYTES = 2 * 1024 * 1024
# A person who reads on in the same recording stands in the audit log once in so long (µs); and so
# many of them are remembered.
_SAME_READER_US, _MOST_READERS = 600_000_000, 1000

_Topics = Annotated[list[str], Query(min_length=1, max_length=_MOST_TOPICS)]
_Rates = Annotated[list[Annotated[float, Query(ge=0, le=1000)]], Query(max_length=_MOST_TOPICS)]
_Points = Annotated[int, Query(ge=1, le=400_000)]


class RecordedTopicPages:
    """The routes of recorded topics."""

    def __init__(self, topics: RecordedTopics, *, clock: Clock, audit: Audit) -> None:
        """Answer from ``topics``; who reads which recording stands in ``audit``."""
        self._topics = topics
        self._clock = clock
        self._audit = audit
        # When a person was last written down to read a recording (monotonic µs).
        self._readers: OrderedDict[tuple[str, str, str], int] = OrderedDict()

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/recorded-topics"
        router.get(at)(self.moment)
        router.get(at + "/messages")(self.messages)
        router.get(
            at + "/bytes",
            response_class=Response,
            responses={200: {"content": {"application/msgpack": {}}}},
        )(self.bytes)
        return router

    async def moment(self, request: Request, at_us: Time) -> MomentShape:
        """List the raw topics that recordings hold of a moment, those that you may have."""
        found = await self._topics.topics_at(
            live_of(request).description, who_of(request).grants, at_us
        )
        return MomentShape(
            topics=_topic_shapes(request, found.topics),
            earlier_us=found.earlier_us,
            later_us=found.later_us,
            problems=[f"{name}: {why}" for name, why in found.problems.items()],
        )

    async def messages(
        self,
        *,
        request: Request,
        topic: _Topics,
        from_us: Time,
        to_us: Time,
        rate: _Rates = [],  # noqa: B006 - FastAPI reads it
    ) -> StretchShape:
        """Give messages of recorded topics as trees: of a stretch, and the last before it.

        ``rate``: of each topic at most so many large messages a second, in the order of
        ``topic``; without it all. A stretch is at most a minute; where it holds too much,
        ``until_us`` says where to go on.
        """
        stretch = await self._read(
            request, topic, rate, span=(from_us, to_us), most_bytes=_MOST_TREE_BYTES
        )
        shapes, until_us = await asyncio.to_thread(_tree_shapes, stretch)
        return StretchShape(
            topics=_topic_shapes(request, stretch.topics),
            messages=shapes,
            until_us=until_us,
        )

    async def bytes(
        self,
        *,
        request: Request,
        topic: _Topics,
        from_us: Time,
        to_us: Time,
        rate: _Rates = [],  # noqa: B006 - FastAPI reads it
        points: _Points = 100_000,
    ) -> Response:
        """Give messages of recorded topics as the robot serialized them, in MessagePack.

        As the route of trees; of a point cloud at most ``points`` points are left.
        """
        stretch = await self._read(
            request, topic, rate, span=(from_us, to_us), most_bytes=_MOST_BYTES
        )
        shapes = _topic_shapes(request, stretch.topics)
        data = await asyncio.to_thread(_encode_bytes, stretch, shapes, points)
        return Response(data, media_type="application/msgpack", headers=STILL)

    async def _read(
        self,
        request: Request,
        topics: list[str],
        rates: list[float],
        *,
        span: tuple[int, int],
        most_bytes: int,
    ) -> ReadStretch:
        if rates and len(rates) != len(topics):
            raise ApiProblem(422, "invalid", "give a rate for each topic, or none at all")
        if not 0 < span[1] - span[0] <= _MOST_SPAN_US:
            raise ApiProblem(422, "invalid", "a stretch lasts up to a minute")
        wanted = dict(zip(topics, rates or [0.0] * len(topics), strict=True))
        asker, live = who_of(request), live_of(request)
        stretch = await self._topics.read_stretch(
            live.description, asker.grants, wanted, span=span, most_bytes=most_bytes
        )
        for recording in stretch.recordings:
            self._append_record(request, live.name, recording)
        return stretch

    def _append_record(self, request: Request, site: str, recording: str) -> None:
        """Write down who reads a recording: not each stretch of it."""
        name = who_of(request).name
        key, now_us = (name, site, recording), self._clock.monotonic_ns() // 1000
        if now_us - self._readers.get(key, -_SAME_READER_US) < _SAME_READER_US:
            return
        self._readers[key] = now_us
        self._readers.move_to_end(key)
        while len(self._readers) > _MOST_READERS:
            self._readers.popitem(last=False)
        self._audit.append_record(
            "recording looked at",
            who=name,
            address=address_of(request),
            site=site,
            message=recording,
        )


def _topic_shapes(request: Request, found: Sequence[FoundTopic]) -> list[RecordedTopicShape]:
    description, grants = live_of(request).description, who_of(request).grants
    return [
        RecordedTopicShape(
            topic=topic.topic,
            type=topic.type,
            latched=topic.latched,
            problem=topic.problem,
            begin_us=begin_us,
            end_us=end_us,
            camera=seen_camera(grants, description, topic.topic, topic.type),
        )
        for topic, begin_us, end_us in found
    ]


def _tree_shapes(stretch: ReadStretch) -> tuple[list[RecordedMessageShape], int]:
    """Make trees of messages; what is left for the next question begins at the moment given."""
    readers: dict[str, Callable[[bytes], dict[str, object]] | None] = {}
    for found in stretch.topics:
        topic = found.topic
        schema = TapSchema(
            type=topic.type[:200],
            encoding=topic.form,
            definition=topic.definition,
            message_encoding=topic.encoding,
        )
        try:
            readers[topic.topic] = tree_reader(schema)
        except MessageUnreadable:
            readers[topic.topic] = None
    shapes = [
        RecordedMessageShape(
            topic=message.topic,
            time_us=message.time_us,
            publish_us=message.publish_us,
            size=len(message.data),
            tree=_tree_of(readers.get(message.topic), message),
        )
        for message in stretch.messages[:_MOST_TREES]
    ]
    left = stretch.messages[_MOST_TREES:]
    return shapes, left[0].time_us if left else stretch.until_us


def _tree_of(read: Callable[[bytes], dict[str, object]] | None, message: RecordedMessage) -> str:
    try:
        tree = "" if read is None else msgspec.json.encode(read(message.data)).decode()
    except MessageUnreadable:
        return ""
    return tree if len(tree) <= MAX_TREE else ""


def _encode_bytes(stretch: ReadStretch, shapes: Sequence[RecordedTopicShape], points: int) -> bytes:
    topics = {found.topic.topic: found.topic for found in stretch.topics}
    messages = []
    for message in stretch.messages:
        topic, data, every = topics[message.topic], message.data, 1
        if topic.type == CLOUD_TYPE:
            data, every = thin_cloud(data, points, ros1=topic.encoding == "ros1")
        if len(data) <= MAX_RAW:
            messages.append(
                RecordedBytes(
                    topic=message.topic,
                    time_us=message.time_us,
                    publish_us=message.publish_us,
                    encoding=topic.encoding,
                    every=every,
                    data=data,
                )
            )
    answer = BytesAnswer(
        topics=[shape.model_dump() for shape in shapes],
        messages=messages,
        until_us=stretch.until_us,
    )
    return msgspec.msgpack.encode(answer)
