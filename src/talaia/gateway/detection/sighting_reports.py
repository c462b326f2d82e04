"""Sightings on their way to the hub: on disk until it has them. Event loop only.

The hub does not answer a sighting; it has one when the link has lived on for a while after it went
out. Until then it is told again on each new link, which changes nothing for a hub that had it. A
gateway that is killed finds them in its folder, and ends those that were in sight when it last
said so.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import os
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol

import msgspec

from talaia.errors import TalaiaError
from talaia.wire.frames import LINK_FROM_GATEWAY, LineCrossing, SightingReport, ZoneStay

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor
    from pathlib import Path

    from talaia.objects.camera_objects import SightingNews
    from talaia.wire.frames import FromGateway

__all__ = ["MOST_KEPT", "DetectionReporter", "ReportTimes", "SightingUplink"]

log = logging.getLogger(__name__)
# With a thumbnail each they take a few megabytes; of more the oldest go.
MOST_KEPT = 300
LOOK_S = 0.05
_ENDING = ".seen"


class SightingUplink(Protocol):
    """The way to the hub; see `talaia.gateway.uplink.send_lanes.SendLanes`."""

    @property
    def seen_waiting(self) -> int:
        """How many sightings have not gone out yet."""
        ...

    def send(self, message: FromGateway) -> None:
        """Queue a message."""
        ...


class ReportTimes(NamedTuple):
    """Times of the reports (s).

    Attributes:
        carried: a link that lives on for so long has carried what went out: a dead one is known
            after three.
        touch: how often the files of what is in sight are touched, which tells a later run until
            when it was.

    """

    carried: float = 5.0
    touch: float = 2.0


USUAL = ReportTimes()


class _Key(NamedTuple):
    """What tells sightings apart."""

    stream: str
    label: str
    began_us: int


class _Kept:
    """One sighting: all of it, and what of it has gone out on the link that stands."""

    def __init__(self, seen: SightingReport) -> None:
        self.seen = seen
        # Monotonic; none while it waits to be sent.
        self.sent_s: float | None = None
        self.thumbnail_sent = b""


class DetectionReporter:
    """Takes news of sightings, and sees that a hub hears of them."""

    def __init__(
        self,
        folder: Path,
        lanes: SightingUplink,
        files: Executor,
        times: ReportTimes = USUAL,
    ) -> None:
        """Take up what an earlier run left.

        Args:
            folder: of the files; made when there is something to keep.
            lanes: to the hub.
            files: a thread that writes; one, so that the writes keep their order.
            times: of what it does again and again.

        """
        self._folder = folder
        self._lanes = lanes
        self._files = files
        self._times = times
        self._takes = False
        # In the order in which they go out; a dict, since it is asked whether one is in it.
        self._due: dict[_Key, None] = {}
        self._wake = asyncio.Event()
        self._complained = False
        # All that the hub may not have yet, by what tells it apart.
        self._kept = {_key_of(sighting): _Kept(sighting) for sighting in _read_left(folder)}

    def report_sighting(self, stream: str, told: SightingNews) -> None:
        """Take news of a sighting on a stream (``device/stream``)."""
        sighting = told.sighting
        key = _Key(stream, sighting.label, sighting.began_us)
        kept = self._kept.get(key)
        seen = SightingReport(
            **key._asdict(),
            many=sighting.most,
            confidence=min(max(sighting.score, 0.0), 1.0),
            ended_us=sighting.ended_us or 0,
            path=told.story.path_on_picture(),
            stays=[
                ZoneStay(zone=zone, entries=visit.entries, dwell_s=visit.dwell_s)
                for zone, visit in told.story.zones
            ],
            crossings=[
                LineCrossing(line=line, left=left, right=right)
                for line, left, right in told.story.crossings
            ],
            speed=told.story.speed,
            thumbnail=told.thumbnail or (b"" if kept is None else kept.seen.thumbnail),
        )
        if kept is None:
            kept = self._kept[key] = _Kept(seen)
        # Newer than what may be on its way, so it is not yet carried.
        kept.seen, kept.sent_s = seen, None
        self._write(key, LINK_FROM_GATEWAY.encode(seen))
        while len(self._kept) > MOST_KEPT:
            self._forget_report(min(self._kept, key=lambda one: one.began_us))
        # What has just happened comes before what is told again.
        self._due = {key: None, **self._due}
        self._wake.set()

    def link_up(self, *, takes: bool) -> None:
        """Tell all of it to a new link, if its hub takes it."""
        self._takes = takes
        for kept in self._kept.values():
            kept.sent_s, kept.thumbnail_sent = None, b""
        self._due = dict.fromkeys(sorted(self._kept, key=lambda one: one.began_us))
        self._wake.set()

    def link_lost(self) -> None:
        """Wait for the next link."""
        self._takes = False

    async def run(self) -> None:
        """Tell and forget until cancelled."""
        loop = asyncio.get_running_loop()
        touched = loop.time()
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self._times.touch):
                    await self._wake.wait()
            self._wake.clear()
            while self._takes and self._due:
                self._send_report(loop.time())
                # One at a time: what has just happened need not wait for many.
                while self._lanes.seen_waiting:  # noqa: ASYNC110 - told by nobody
                    await asyncio.sleep(LOOK_S)
            if loop.time() - touched >= self._times.touch:
                touched = loop.time()
                self._expire_sightings(touched)

    def _send_report(self, now_s: float) -> None:
        key = next(iter(self._due))
        del self._due[key]
        kept = self._kept.get(key)
        if kept is None:
            return
        seen = kept.seen
        # Pictures are most of the bytes: this link has carried this one already.
        if seen.thumbnail == kept.thumbnail_sent:
            seen = msgspec.structs.replace(seen, thumbnail=b"")
        kept.sent_s, kept.thumbnail_sent = now_s, kept.seen.thumbnail
        self._lanes.send(seen)

    def _expire_sightings(self, now_s: float) -> None:
        """Forget what the hub has, and keep the time of what is in sight."""
        for key, kept in list(self._kept.items()):
            if not kept.seen.ended_us:
                self._run_on_disk(partial(os.utime, self._report_path(key)))
            elif (
                self._takes
                and kept.sent_s is not None
                and now_s - kept.sent_s >= self._times.carried
                and not self._lanes.seen_waiting
            ):
                self._forget_report(key)

    def _forget_report(self, key: _Key) -> None:
        del self._kept[key]
        self._due.pop(key, None)
        self._run_on_disk(partial(self._report_path(key).unlink, missing_ok=True))

    def _report_path(self, key: _Key) -> Path:
        named = hashlib.sha256(f"{key.stream}\n{key.label}".encode()).hexdigest()[:16]
        return self._folder / f"{key.began_us}-{named}{_ENDING}"

    def _write(self, key: _Key, data: bytes) -> None:
        path = self._report_path(key)

        def write() -> None:
            self._folder.mkdir(parents=True, exist_ok=True)
            # Renamed over the old one: a gateway that is killed leaves one of both whole.
            beside = path.with_suffix(".new")
            beside.write_bytes(data)
            beside.replace(path)

        self._run_on_disk(write)

    def _run_on_disk(self, work: Callable[[], object]) -> None:
        def done() -> None:
            try:
                work()
                self._complained = False
            # Forgotten a moment before it was to be touched.
            except FileNotFoundError:
                pass
            except OSError as error:
                if not self._complained:
                    log.warning("sightings cannot be kept in %s: %s", self._folder, error)
                self._complained = True

        self._files.submit(done)


def _key_of(seen: SightingReport) -> _Key:
    return _Key(seen.stream, seen.label, seen.began_us)


def _read_left(folder: Path) -> list[SightingReport]:
    """Read what an earlier run left; what was in sight then has ended when it was touched last."""
    found = []
    for path in sorted(folder.glob("*" + _ENDING))[-MOST_KEPT:]:
        try:
            seen = LINK_FROM_GATEWAY.decode(path.read_bytes())
            touched_us = path.stat().st_mtime_ns // 1000
        except (OSError, TalaiaError) as error:
            log.warning("%s is not read: %s", path, error)
            # Else it would be warned of at each start.
            path.unlink(missing_ok=True)
            continue
        if isinstance(seen, SightingReport):
            ended_us = seen.ended_us or max(seen.began_us, touched_us)
            found.append(msgspec.structs.replace(seen, ended_us=ended_us))
    return found
