"""The past, played by Foxglove's own control: what comes, when, and for whom."""

from __future__ import annotations

import json
import struct
from datetime import UTC, datetime

import pytest

from talaia.hub.clients.foxglove.playback_position import (
    PlaybackPosition,
    PlaybackWindow,
    read_window,
)
from talaia.wire import frames
from talaia.wire.foxglove.client_messages import FoxglovePlayback
from talaia.wire.foxglove.codec import PlaybackStatus

from ...everyone.world import NOW
from .foxglove_peer import V1, client_of, topics_of

SECOND = 1_000_000
PLAYING, PAUSED, ENDED = PlaybackStatus.PLAYING, PlaybackStatus.PAUSED, PlaybackStatus.ENDED


def time_text(time_us: int) -> str:
    return datetime.fromtimestamp(time_us / 1e6, UTC).isoformat().replace("+00:00", "Z")


def window_of(from_us: int, to_us: int) -> str:
    return f"&from={time_text(from_us)}&to={time_text(to_us)}"


async def control(client, *, play: bool, speed=1.0, seek_us=None, number=b"n"):
    """Ask as Foxglove does; give the status, the time (µs) and whether it sought."""
    seeks = seek_us is not None
    asked = struct.pack("<BBfBQI", 3, not play, speed, seeks, (seek_us or 0) * 1000, len(number))
    await client.say(asked + number)
    return read_state(await client.hear("state", lambda frame: frame.endswith(number)))


def read_state(frame: bytes):
    status, time_ns, _, sought = struct.unpack_from("<BQfB", frame, 1)
    return status, time_ns // 1000, bool(sought)


def read_data(frame: bytes):
    subscription, time_ns = struct.unpack_from("<IQ", frame, 1)
    return subscription, time_ns // 1000, json.loads(frame[13:]).get("value")


async def store_past(world) -> None:
    """Put ten seconds into the history: a number each second, and one that is not for all."""
    gateway = world.gateways["agv"]
    rows = [("base/open", NOW + at * SECOND, at + 0.5) for at in range(10)]
    rows += [("base/shut", NOW + at * SECOND, 100.0 + at) for at in range(10)]
    rows += [("base/words", NOW + 3 * SECOND, "third")]
    first = gateway.sequence
    await gateway.samples(*rows)
    await gateway.hear(frames.Ack, lambda said: said.below >= first + len(rows))


async def test_window_is_played_paused_sought_and_ends(world) -> None:
    await store_past(world)
    client = await client_of(world, "driver", more=window_of(NOW, NOW + 9 * SECOND))
    info = await client.hear("serverInfo")
    assert info["capabilities"] == ["playbackControl", "time"]
    assert info["dataStartTime"] == {"sec": NOW // SECOND, "nsec": 0}
    assert info["dataEndTime"] == {"sec": NOW // SECOND + 9, "nsec": 0}
    topics = await topics_of(client)
    assert set(topics) == {"/base/open", "/base/shut", "/base/words"}
    wanted = [
        {"id": 1, "channelId": topics["/base/open"]},
        {"id": 2, "channelId": topics["/base/words"]},
    ]
    await client.say({"op": "subscribe", "subscriptions": wanted})
    # What was true at the beginning, before anything is played.
    assert read_data(await client.hear("data")) == (1, NOW, 0.5)

    assert (await control(client, play=True, speed=20.0))[0] == PLAYING
    ended = read_state(await client.hear("state", lambda frame: frame[1] == ENDED))
    assert ended == (ENDED, NOW + 9 * SECOND, False)
    played = [read_data(frame) for kind, frame in client.events if kind == "data"]
    assert [row for row in played if row[0] == 1][-9:] == [
        (1, NOW + at * SECOND, at + 0.5) for at in range(1, 10)
    ]
    assert (2, NOW + 3 * SECOND, "third") in played
    times = [struct.unpack("<Q", frame[1:9])[0] for kind, frame in client.events if kind == "time"]
    assert times == sorted(times)
    assert times[-1] == (NOW + 9 * SECOND) * 1000

    # Back to where words were not yet said: what was newest there is told, and nothing goes on.
    client.events.clear()
    at_us = NOW + 2 * SECOND + 1
    assert await control(client, play=False, seek_us=at_us) == (PAUSED, at_us, True)
    assert read_data(await client.hear("data")) == (1, NOW + 2 * SECOND, 2.5)
    # Out of the window it goes to its end.
    assert (await control(client, play=False, seek_us=NOW * 2, number=b"far"))[1] == ended[1]
    assert not [frame for kind, frame in client.events if kind == "time"]
    await client.close()


async def test_past_is_for_whom_it_is_and_moves_nothing(world) -> None:
    await store_past(world)
    gateway = world.gateways["agv"]
    gateway.heard.clear()
    client = await client_of(world, "guest", more=window_of(NOW, NOW + 9 * SECOND))
    assert set(await topics_of(client)) == {"/base/open"}
    asked = [{"id": number, "channelId": number} for number in range(1, 30)]
    await client.say({"op": "subscribe", "subscriptions": asked})
    channel = {"id": 1, "topic": "/v", "encoding": "json", "schemaName": "geometry_msgs/Twist"}
    await client.say({"op": "advertise", "channels": [channel]})
    await client.say(struct.pack("<BI", 1, 1) + b'{"linear": {"x": 1}}')
    await client.call(1, 1, b"{}")
    await client.say({"op": "fetchAsset", "uri": "package://base/a.stl", "requestId": 1})
    await control(client, play=True, speed=1000.0)
    await client.hear("state", lambda frame: frame[1] == ENDED)
    values = {read_data(frame)[2] for kind, frame in client.events if kind == "data"}
    assert values == {at + 0.5 for at in range(10)}
    said = "".join(frame for frame in client.frames if isinstance(frame, str))
    assert "the past is played" in said
    assert "/base/shut" not in said
    kinds = (frames.CommandRequest, frames.LeaseRequest, frames.StopRequest)
    assert not [message for message in gateway.heard if isinstance(message, kinds)]
    await client.close()


async def test_window_that_is_none_is_told_and_played_by_nobody(world) -> None:
    for more in ("&from=yesterday", "&to=2026-11-23T10:00:00Z", window_of(NOW, NOW)):
        client = await client_of(world, "driver", more=more)
        assert (await client.hear("status"))["message"]
        await client.hear("closed")
    more = window_of(NOW, NOW + SECOND)
    client = await client_of(world, "driver", more=more, subprotocol=V1)
    assert "foxglove.sdk.v1 alone" in (await client.hear("status"))["message"]
    await client.hear("closed")


@pytest.mark.parametrize(
    ("query", "read"),
    [
        ({}, None),
        ({"from": "1970-01-01T00:00:01Z"}, PlaybackWindow(SECOND, NOW)),
        (
            {"from": "2023-11-14T12:00:00.000001 02:00", "to": "2023-11-14T11:00:00Z"},
            PlaybackWindow(1_699_956_000_000_001, 1_699_959_600_000_000),
        ),
        # What is still to come cannot be played.
        (
            {"from": "2023-11-14T12:00:00Z", "to": "2999-01-01T00:00:00Z"},
            (1_699_963_200_000_000, NOW),
        ),
        ({"from": "2023-11-14T12:00:00"}, str),
        ({"from": "2023-11-14T12:00:00Z", "to": "2023-11-14T11:00:00Z"}, str),
        ({"from": "1960-01-01T00:00:00Z"}, str),
    ],
)
def test_address_names_a_window_with_zones(query, read) -> None:
    found = read_window(query, NOW)
    assert found == read or (read is str and isinstance(found, str))


def test_position_keeps_within_window_and_speeds() -> None:
    position = PlaybackPosition(PlaybackWindow(100 * SECOND, 200 * SECOND))
    ask = FoxglovePlayback(play=True, speed=2.0, seek_ns=None, request_id="")
    assert position.status_at(0) is PAUSED
    position.control(ask, 0)
    assert position.time_at(10 * 10**9) == 120 * SECOND
    # What is no speed leaves the one that there is; what is too fast is played fast.
    for speed, kept in ((float("nan"), 2.0), (-1.0, 2.0), (0.0, 2.0), (1e9, 1000.0), (1e-9, 0.01)):
        position.control(FoxglovePlayback(play=True, speed=speed, seek_ns=0, request_id=""), 0)
        assert (position.speed, position.time_at(0)) == (kept, 100 * SECOND)
    position.control(
        FoxglovePlayback(play=True, speed=1.0, seek_ns=2**64 - 1, request_id=""), 10**9
    )
    assert position.status_at(2 * 10**9) is ENDED
