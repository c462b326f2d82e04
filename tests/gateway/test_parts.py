"""The smaller parts: batches, qualities of service, requests, what is kept on disk."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace as Message
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.adapters.ros2.qos import QosProfile, fits, quality_for
from talaia.gateway.adapters.ros2.requests import fill, outcome_of
from talaia.gateway.driving.drive_keys import strongest_key
from talaia.gateway.driving.persistent_state import LeaseEpochs, PersistentStops
from talaia.gateway.driving.stop_latch import LatchedStop
from talaia.gateway.errors import FieldError, SpoolError
from talaia.gateway.freeze_watchdog import FreezeDetector
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.run import main
from talaia.gateway.samples.batching import Batcher, records_of
from talaia.gateway.spool.segment import SampleRecord
from talaia.model.site import Drive, DriveMessage
from talaia.wire.columns import Columns, unpack
from talaia.wire.frames import LINK_FROM_GATEWAY, CommandPhase, SampleBatch

if TYPE_CHECKING:
    from pathlib import Path


def columns(times: list[int], texts: dict[int, str] | None = None) -> Columns:
    count = len(times)
    return Columns(
        np.zeros(count, np.uint16),
        np.array(times, np.int64),
        np.arange(count, dtype=np.float64),
        texts or {},
    )


@given(st.lists(st.integers(0, 2**40), max_size=50), st.sets(st.integers(0, 49)))
def test_columns_come_back_from_their_batches_however_far_apart(
    times: list[int], marked: set[int]
) -> None:
    texts = {at: f"t{at}" for at in marked if at < len(times)}
    made = records_of(columns(times, texts), "b", "c", 100)
    back, words, sequence = [], {}, 100
    for record in made:
        frame = LINK_FROM_GATEWAY.decode(record.body)
        assert isinstance(frame, SampleBatch)
        assert (frame.first, record.first) == (sequence, sequence)
        part = unpack(frame.base_us, frame.channel, frame.offset, frame.value, frame.texts)
        words |= {sequence - 100 + at: text for at, text in part.texts.items()}
        back += list(part.time_us)
        sequence = record.end
    assert back == times
    assert words == texts


async def test_batches_are_numbered_and_made_once_per_flush() -> None:
    kept: list[SampleRecord] = []
    batcher = Batcher(
        loop=asyncio.get_running_loop(),
        boot="b",
        catalogue="c",
        flush=60.0,
        keep=kept.append,
        lose=lambda *_: None,
    )
    batcher.put_samples(columns([1, 2]))
    batcher.put_samples(columns([3], {0: "three"}))
    batcher.flush()
    frame = LINK_FROM_GATEWAY.decode(kept[0].body)
    assert isinstance(frame, SampleBatch)
    assert frame.texts == {2: "three"}
    batcher.put_samples(columns([4]))
    batcher.flush()
    batcher.flush()
    assert [(each.first, each.end) for each in kept] == [(0, 3), (3, 4)]


async def test_time_in_which_nothing_was_heard_is_a_gap_with_a_number_of_its_own() -> None:
    kept: list[SampleRecord] = []
    lost: list[tuple[SampleRecord, str]] = []
    batcher = Batcher(
        loop=asyncio.get_running_loop(), boot="b", catalogue="c", flush=60.0, keep=kept.append,
        lose=lambda record, why: lost.append((record, why)),
    )  # fmt: skip
    batcher.put_samples(columns([1, 2]))
    batcher.flush()
    batcher.missed(10, 20, "stood still")
    batcher.put_samples(columns([3]))
    batcher.flush()
    assert lost == [(SampleRecord(2, 1, 10, 20, b""), "stood still")]
    assert [(each.first, each.end) for each in kept] == [(0, 2), (3, 4)]


def test_process_that_stood_still_knows_from_when_to_when() -> None:
    stalls = FreezeDetector(0)
    assert stalls.at(1_000 * SECOND, SECOND) is None
    # The wall clock may have been set meanwhile: how long it was is the other clock's to say.
    assert stalls.at(5_000 * SECOND, 31 * SECOND) == (4_970_000_000, 5_000_000_000)
    assert stalls.at(5_001 * SECOND, 32 * SECOND) is None


qualities = st.builds(QosProfile, st.booleans(), st.booleans())


@given(st.lists(qualities, min_size=1, max_size=5))
def test_subscription_hears_every_publisher_it_was_made_for(offers: list[QosProfile]) -> None:
    asked = quality_for(offers)
    assert fits(asked, offers)
    if all(each.reliable for each in offers):
        assert asked.reliable
    if not all(each.latched for each in offers):
        assert not asked.latched


def test_subscription_is_changed_only_for_a_publisher_it_would_not_hear() -> None:
    assert not fits(QosProfile(reliable=True, latched=False), [QosProfile(False, False)])  # noqa: FBT003
    assert fits(QosProfile(reliable=False, latched=False), [QosProfile(True, True)])  # noqa: FBT003


def test_request_fields_are_set_by_path_in_the_types_they_have() -> None:
    request = Message(to=Message(alt=0.0), steps=0, quick=False, note="", list=[0, 0])
    fill(request, {"to.alt": 4, "steps": 3.0, "quick": True, "note": "x", "list[1]": 7})
    assert request == Message(to=Message(alt=4.0), steps=3, quick=True, note="x", list=[0, 7])
    assert isinstance(request.to.alt, float)


@pytest.mark.parametrize(
    "fields",
    [{"nowhere": 1}, {"steps": 1.5}, {"steps": "x"}, {"quick": 1}, {"list[9]": 1}, {"to..alt": 1}],
)
def test_field_that_does_not_fit_is_refused(fields: dict) -> None:
    request = Message(to=Message(alt=0.0), steps=0, quick=False, list=[0])
    with pytest.raises(FieldError):
        fill(request, fields)


def test_robots_own_no_is_a_failure_with_its_words() -> None:
    assert outcome_of(Message(success=False, message="stuck")) == CommandOutcome(
        CommandPhase.FAILED, "stuck"
    )
    assert outcome_of(Message(success=True, message="ok")) == CommandOutcome(
        CommandPhase.SUCCEEDED, "ok"
    )
    assert outcome_of(Message(result=3)) == CommandOutcome(CommandPhase.SUCCEEDED, "")


KEYS = Drive(topic="/control", message=DriveMessage.KEYS, max_speed=0.2, max_turn=2.0)


@pytest.mark.parametrize(
    ("linear", "angular", "key"),
    [(0.1, 0, "w"), (-0.1, 0, "x"), (0, 1, "a"), (0, -1, "d"), (0, 0, "s"), (0.05, 1.9, "a")],
)
def test_velocity_becomes_the_key_of_its_stronger_direction(
    linear: float, angular: float, key: str
) -> None:
    assert strongest_key(KEYS, linear, angular) == key


def test_epochs_rise_over_restarts(tmp_path: Path) -> None:
    path = tmp_path / "e.json"
    seen = []
    for count in (1, 1500, 1003, 2002, 1):
        epochs = LeaseEpochs(path)
        seen += [epochs.next() for _ in range(count)]
    assert seen == sorted(set(seen))


def test_damaged_epochs_are_not_guessed(tmp_path: Path) -> None:
    path = tmp_path / "e.json"
    path.write_bytes(b"12x")
    with pytest.raises(SpoolError, match="not guessed"):
        LeaseEpochs(path)


def test_stops_are_kept_by_device(tmp_path: Path) -> None:
    stops = PersistentStops(tmp_path / "s.json")
    stops.write("a", LatchedStop("1", "Ada", 5))
    stops.write("b", LatchedStop("2", "Ben", 6))
    stops.write("a", None)
    later = PersistentStops(tmp_path / "s.json")
    assert later.get("a") is None
    assert later.get("b") == LatchedStop("2", "Ben", 6)


@pytest.mark.parametrize(
    ("site", "hub", "said"),
    [
        ("talaia: 1\nsite: s\nname: S\ndevices: {d: {nam: D}}", "wss://h:1", "$.devices.d.nam"),
        ("talaia: 1\nsite: s\nname: S\ndevices: {}", "wss://h:1", "$.devices"),
        ("talaia: 1\nsite: s\nname: S\ndevices: {d: {name: D}}", "ws://h:1", "plain text"),
    ],
)
def test_what_cannot_start_says_why_and_ends_with_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], site: str, hub: str, said: str
) -> None:
    (tmp_path / "site.yaml").write_text(site)
    (tmp_path / "key").write_text("k\n")
    key = str(tmp_path / "key")
    assert main([str(tmp_path / "site.yaml"), "--hub", hub, "--key-file", key]) == 2
    error = capsys.readouterr().err
    assert error.startswith("talaia gateway: ")
    assert said in error


@pytest.mark.robot
def test_lists_in_a_request_grow_to_what_is_filled_in_and_its_answer_is_read() -> None:
    srv = pytest.importorskip("rcl_interfaces.srv")
    request = srv.SetParametersAtomically.Request()
    fields = {
        "parameters[0].name": "ra",
        "parameters[0].value.type": 3,
        "parameters[0].value.double_value": 5.5,
        "parameters[2].name": "dec",
    }
    fill(request, fields)
    assert [each.name for each in request.parameters] == ["ra", "", "dec"]
    assert request.parameters[0].value.double_value == 5.5
    with pytest.raises(FieldError):
        fill(request, {"parameters[64].name": "too far"})
    with pytest.raises(FieldError):
        fill(request, {"nothing[0].name": "x"})
    response = srv.SetParametersAtomically.Response()
    response.result.successful, response.result.reason = False, "below the horizon"
    assert outcome_of(response) == CommandOutcome(CommandPhase.FAILED, "below the horizon")
    response.result.successful = True
    assert outcome_of(response).phase is CommandPhase.SUCCEEDED
