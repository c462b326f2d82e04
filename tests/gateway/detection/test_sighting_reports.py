"""Sightings that wait for a hub, and what of a change of cameras may come from one."""

from __future__ import annotations

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from patience import PATIENCE_S

from talaia.clock import SECOND
from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.change_policy import forbidden_changes
from talaia.gateway.detection.sighting_reports import MOST_KEPT, DetectionReporter, ReportTimes
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.interlocks import Interlocks
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.gateway.uplink.send_lanes import SendLanes
from talaia.model.derived_signals import with_counts
from talaia.model.yaml_text.load import load_site
from talaia.objects.camera_objects import SightingNews
from talaia.objects.sightings import ObjectSighting
from talaia.wire.frames import LINK_FROM_GATEWAY, InterlockState, SightingReport

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from talaia.model.site import Site

JPEG = b"\xff\xd8" + bytes(1000)


def told(began_us: int, ended_us: int | None = None, thumbnail: bytes = JPEG) -> SightingNews:
    return SightingNews(ObjectSighting("person", 2, 0.75, began_us, ended_us), thumbnail)


class Bench:
    """A gateway's telling, and a link whose frames the test takes."""

    def __init__(self, folder: Path) -> None:  # noqa: D107
        self.folder = folder
        self.lanes = SendLanes(lambda: None)
        self.files = ThreadPoolExecutor(1)
        self.telling = DetectionReporter(
            folder, self.lanes, self.files, ReportTimes(carried=0.05, touch=0.02)
        )

    def link(self, *, takes: bool = True) -> None:
        self.lanes.link_up()
        self.telling.link_up(takes=takes)

    def lose(self) -> None:
        self.lanes.link_lost()
        self.telling.link_lost()

    async def next(self) -> SightingReport:
        async with asyncio.timeout(PATIENCE_S):
            while (data := self.lanes.next()) is None:  # noqa: ASYNC110 - told by nobody
                await asyncio.sleep(0.01)
        seen = LINK_FROM_GATEWAY.decode(data)
        assert isinstance(seen, SightingReport)
        return seen

    def kept(self) -> list[str]:
        self.files.submit(lambda: None).result()
        return sorted(each.name for each in self.folder.glob("*.seen"))

    async def until_forgotten(self) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while self.kept():  # noqa: ASYNC110 - told by nobody
                await asyncio.sleep(0.01)


@asynccontextmanager
async def telling(tmp_path: Path) -> AsyncIterator[Bench]:
    bench = Bench(tmp_path / "sightings")
    running = asyncio.ensure_future(bench.telling.run())
    try:
        yield bench
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        bench.files.shutdown()


async def test_thumbnail_goes_out_once_on_a_link_and_again_on_the_next(tmp_path: Path) -> None:
    async with telling(tmp_path) as bench:
        bench.link()
        bench.telling.report_sighting("base/front", told(7))
        first = await bench.next()
        assert (first.stream, first.label, first.many) == ("base/front", "person", 2)
        assert (first.began_us, first.ended_us, first.thumbnail) == (7, 0, JPEG)
        bench.telling.report_sighting("base/front", told(7, thumbnail=b""))
        assert (await bench.next()).thumbnail == b""
        bench.lose()
        bench.link()
        assert (await bench.next()).thumbnail == JPEG


async def test_what_a_link_has_carried_is_forgotten_and_what_goes_on_is_not(
    tmp_path: Path,
) -> None:
    async with telling(tmp_path) as bench:
        bench.telling.report_sighting("base/front", told(7))
        assert len(bench.kept()) == 1
        bench.link()
        await bench.next()
        bench.telling.report_sighting("base/front", told(7, ended_us=9, thumbnail=b""))
        assert (await bench.next()).ended_us == 9
        await bench.until_forgotten()


async def test_hub_that_takes_no_sightings_is_told_none_and_they_wait(tmp_path: Path) -> None:
    async with telling(tmp_path) as bench:
        bench.link(takes=False)
        bench.telling.report_sighting("base/front", told(7, ended_us=9))
        bench.lose()
        bench.link()
        assert (await bench.next()).began_us == 7


async def test_killed_gateway_tells_in_its_next_run_until_when_it_saw_something(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "sightings"
    bench = Bench(folder)
    bench.telling.report_sighting("base/front", told(1_000_000))
    (name,) = bench.kept()
    # No end was ever written; the file was touched last at five seconds.
    os.utime(folder / name, (5, 5))
    bench.files.shutdown()
    async with telling(tmp_path) as later:
        later.link()
        seen = await later.next()
        assert (seen.began_us, seen.ended_us, seen.thumbnail) == (1_000_000, 5_000_000, JPEG)
        await later.until_forgotten()


async def test_file_that_is_no_sighting_is_taken_away(tmp_path: Path) -> None:
    folder = tmp_path / "sightings"
    folder.mkdir()
    (folder / "1-x.seen").write_bytes(b"half a")
    async with telling(tmp_path) as bench:
        assert bench.kept() == []


async def test_of_too_many_the_oldest_go(tmp_path: Path) -> None:
    async with telling(tmp_path) as bench:
        for began in range(MOST_KEPT + 5):
            bench.telling.report_sighting("base/front", told(began, ended_us=began + 1))
        names = bench.kept()
        assert len(names) == MOST_KEPT
        assert min(int(each.partition("-")[0]) for each in names) == 5


# ── what adapters see, and what a hub may change ──

TEXT = """\
talaia: 1
site: yard
name: Yard
ros2: {}
object_models: {ours: {file: a.onnx, kind: yolo, classes: [person]}}
devices:
  base:
    name: Base
    drive: {topic: /cmd_vel, max_speed: 1, max_turn: 1}
    signals:
      speed: {name: Speed, source: {topic: /speed, type: std_msgs/msg/Float64, field: data}}
    streams:
      front:
        name: Front camera
        source: {topic: /front, type: sensor_msgs/msg/Image}
        detect: {classes: [person]}
      rear:
        name: Rear camera
        source: {topic: /rear, type: sensor_msgs/msg/Image}
        detect: {classes: [person]}
interlocks:
  path:
    name: Way
    when: [{signal: base/front_person, above: 0}]
    refuse: [base/drive]
    dwell: 0
"""


def site(old: str = "", new: str = "") -> Site:
    assert old in TEXT
    return with_counts(load_site(TEXT.replace(old, new, 1)))


def test_adapter_is_told_nothing_of_what_is_seen() -> None:
    roster = ChannelNumbering(site())
    (share,) = scopes_of(site(), roster)
    assert list(share.devices["base"].signals) == ["speed"]
    assert share.channel.keys() == {"base/speed"}
    assert share.guarded == frozenset()
    # So it goes on as it is when that changes.
    other = scopes_of(site("detect: {classes: [person]}", "detect: {classes: [dog, person]}"))
    assert [each._replace(channel={}) for each in other] == [share._replace(channel={})]


@pytest.mark.parametrize(
    ("old", "new", "accepts", "where"),
    [
        ("a.onnx", "b.onnx", AcceptedChanges.ALL, "$.object_models"),
        (
            "classes: [person]}\n      rear",
            "classes: [person], confidence: 0.99}\n      rear",
            AcceptedChanges.READINGS,
            "$.devices.base.signals.front_person",
        ),
        (
            "topic: /front",
            "topic: /other",
            AcceptedChanges.READINGS,
            "$.devices.base.signals.front_person",
        ),
    ],
)
def test_hub_changes_neither_the_file_that_is_run_nor_the_eye_of_an_interlock(
    old: str, new: str, accepts: AcceptedChanges, where: str
) -> None:
    assert [each.where for each in forbidden_changes(site(), site(old, new), accepts)] == [where]


def test_hub_may_change_what_is_only_looked_at() -> None:
    before = site()
    after = with_counts(
        load_site(
            TEXT.replace("topic: /rear, type: sensor_msgs/msg/Image}\n        detect: "
                         "{classes: [person]}",
                         "topic: /rear, type: sensor_msgs/msg/Image}\n        detect: "
                         "{classes: [dog], confidence: 0.4}")
        )
    )  # fmt: skip
    assert before != after
    assert forbidden_changes(before, after, AcceptedChanges.READINGS) == []


class Nobody:
    """Readings of a detector that sees nobody, and a output whose words are kept."""

    def __init__(self) -> None:  # noqa: D107
        self.said: list[object] = []

    def latest(self, _address: str) -> ChannelReading | None:
        return ChannelReading(0.0, 10 * SECOND)

    def send(self, message: object) -> None:
        self.said.append(message)

    def record_event(self, *_: object, **_more: object) -> None: ...


def test_interlock_begins_locked_when_its_camera_is_to_see_otherwise() -> None:
    nobody, now_ns = Nobody(), 10 * SECOND
    interlocks = Interlocks(
        site=site(), readings=nobody, output=nobody, run=lambda _label, _steps: None, now_ns=now_ns
    )
    interlocks.evaluate_all(now_ns + SECOND)
    assert interlocks.refusal_reason("base", "drive", now_ns + SECOND) == ""
    said = len(nobody.said)
    interlocks.redescribe(site("name: Front camera", "name: Bow"), now_ns + SECOND)
    assert len(nobody.said) == said
    surer = ("classes: [person]}\n      rear", "classes: [person], confidence: 0.99}\n      rear")
    interlocks.redescribe(site(*surer), now_ns + SECOND)
    state = nobody.said[-1]
    assert isinstance(state, InterlockState)
    assert (state.locked, state.why) == (True, "its description has changed")
