"""Raw topics of a past moment, from the recordings that hold it, under the rights of live ones."""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.auth.permissions import may_tap
from talaia.hub.live.files.recording_files import file_key
from talaia.hub.live.recorded.errors import RecordingUnreadable
from talaia.hub.store.sites.recordings import RecordingState

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.files.ports import Openable
    from talaia.hub.live.files.recordings import Recordings
    from talaia.hub.live.recorded.recording_index import (
        RecordedMessage,
        RecordedTopic,
        RecordingIndex,
    )
    from talaia.hub.store.sites.recordings import Recorded
    from talaia.model.site import Site

__all__ = ["FoundTopic", "MomentTopics", "ReadStretch", "RecordedTopics"]

_LOG = logging.getLogger(__name__)
# Files whose index is held, and questions that read files at the same time.
_MOST_INDEXES, _MOST_READING = 16, 2
# Recordings that are looked into for one question.
_MOST_FILES = 8


class FoundTopic(NamedTuple):
    """A topic that somebody may have, in one recording.

    Attributes:
        topic: what the file says of it.
        begin_us: of its recording (UTC).
        end_us: see above.

    """

    topic: RecordedTopic
    begin_us: int
    end_us: int


class MomentTopics(NamedTuple):
    """What recordings hold of a moment.

    Attributes:
        topics: by name.
        earlier_us: the end of the nearest recording before the moment; None: there is none.
        later_us: the begin of the nearest one after it; None: there is none.
        problems: why a recording of the moment cannot be read, by its id.

    """

    topics: list[FoundTopic]
    earlier_us: int | None
    later_us: int | None
    problems: dict[str, str]


class ReadStretch(NamedTuple):
    """What recordings hold of a stretch of time.

    Attributes:
        topics: those that were asked for and may be had, once for each recording.
        messages: by time.
        until_us: all up to here is there (not included).
        recordings: ids of what was read.

    """

    topics: list[FoundTopic]
    messages: list[RecordedMessage]
    until_us: int
    recordings: list[str]


class RecordedTopics:
    """Reads the recordings of all sites."""

    def __init__(self, recordings: Recordings) -> None:
        """Read the files of ``recordings``."""
        self._recordings = recordings
        # By key and size, since a whole file never changes; the one used last stands last.
        self._indexes: OrderedDict[tuple[str, int], RecordingIndex | str] = OrderedDict()
        # Unpacking takes a core: driving and samples are to have the rest.
        self._reading = asyncio.Semaphore(_MOST_READING)

    async def topics_at(self, site: Site, grants: Grants, at_us: int) -> MomentTopics:
        """List the topics that recordings hold of a moment, as far as somebody may have them.

        Raises:
            StoreDown: the database or the store of files does not answer.

        """
        rows = _readable(await self._recordings.recordings_of(site.site))
        here = [row for row in rows if row.begin_us <= at_us <= row.end_us]
        found: dict[str, FoundTopic] = {}
        problems = {}
        for row in here[:_MOST_FILES]:
            index = await self._index_of(row)
            if isinstance(index, str):
                problems[row.id] = index
                continue
            for topic in index.topics.values():
                if _allows(grants, site, topic):
                    found.setdefault(topic.topic, FoundTopic(topic, row.begin_us, row.end_us))
        others = [row for row in rows if _may_have_any(grants, site, row)]
        return MomentTopics(
            topics=[found[name] for name in sorted(found)],
            earlier_us=max((row.end_us for row in others if row.end_us < at_us), default=None),
            later_us=min((row.begin_us for row in others if row.begin_us > at_us), default=None),
            problems=problems,
        )

    async def read_stretch(
        self,
        site: Site,
        grants: Grants,
        rates: Mapping[str, float],
        *,
        span: tuple[int, int],
        most_bytes: int,
    ) -> ReadStretch:
        """Read topics from the first moment of ``span`` on, before the second (µs, UTC).

        A topic that somebody may not have is as one that was not recorded.

        Raises:
            StoreDown: the database or the store of files does not answer.

        """
        from_us, to_us = span
        rows = await self._recordings.recordings_between(
            site.site, from_us, max(from_us, to_us - 1)
        )
        topics: list[FoundTopic] = []
        messages: list[RecordedMessage] = []
        until_us = to_us
        read = []
        # The oldest first: what stands in two recordings is read of the first.
        for row in sorted(_readable(rows), key=lambda row: row.begin_us)[:_MOST_FILES]:
            index = await self._index_of(row)
            if isinstance(index, str):
                continue
            allowed = [
                FoundTopic(index.topics[name], row.begin_us, row.end_us)
                for name in rates
                if name in index.topics and _allows(grants, site, index.topics[name])
            ]
            topics += allowed
            wanted = {
                found.topic.topic: rates[found.topic.topic]
                for found in allowed
                if not found.topic.problem
            }
            if not wanted:
                continue
            try:
                async with self._reading:
                    stretch = await asyncio.to_thread(
                        index.read_stretch, wanted, from_us, until_us, most_bytes=most_bytes
                    )
            except (OSError, RecordingUnreadable) as error:
                self._remember(row, str(error))
                continue
            read.append(row.id)
            messages += stretch.messages
            until_us = min(until_us, stretch.until_us)
        # What two recordings hold is the same message with the same times.
        once = {
            (message.topic, message.time_us, message.publish_us, len(message.data)): message
            for message in messages
            if message.time_us < until_us
        }
        ordered = sorted(once.values(), key=lambda message: message.time_us)
        return ReadStretch(topics, ordered, until_us, read)

    async def _index_of(self, row: Recorded) -> RecordingIndex | str:
        """Give a file's index, or why it has none."""
        file = self._recordings.store.name_file(file_key(row))
        key = (file_key(row), row.size)
        known = self._indexes.get(key)
        if known is None:
            try:
                async with self._reading:
                    known = await asyncio.to_thread(_open_index, file)
            except (OSError, RecordingUnreadable) as error:
                _LOG.warning("the recording %s of %s cannot be read: %s", row.id, row.site, error)
                missing = "its file cannot be read"
                known = str(error) if isinstance(error, RecordingUnreadable) else missing
            self._indexes[key] = known
        self._indexes.move_to_end(key)
        while len(self._indexes) > _MOST_INDEXES:
            self._indexes.popitem(last=False)
        return known

    def _remember(self, row: Recorded, why: str) -> None:
        _LOG.warning("the recording %s of %s cannot be read: %s", row.id, row.site, why)
        self._indexes[file_key(row), row.size] = why


def _open_index(file: Openable) -> RecordingIndex:
    # Here, since a hub starts without what reads such files.
    from talaia.hub.live.recorded.recording_index import RecordingIndex

    return RecordingIndex(file)


def _readable(rows: Sequence[Recorded]) -> list[Recorded]:
    """Give the recordings of messages that are here as a whole."""
    return [row for row in rows if not row.stream and row.state is RecordingState.COMPLETE]


def _allows(grants: Grants, site: Site, topic: RecordedTopic) -> bool:
    # By the rules of now, as for what comes now.
    return may_tap(grants, site, topic.topic, type_name=topic.type, definition=topic.definition)


def _may_have_any(grants: Grants, site: Site, row: Recorded) -> bool:
    # Types are only in the file; that there is a recording tells nothing of what is in it.
    return any(may_tap(grants, site, topic) for topic in row.topics)
