"""Cameras as channels of a Foxglove client."""

from __future__ import annotations

import base64
import json
from typing import TYPE_CHECKING

import av
import numpy as np
import pytest

from talaia.gateway.video.h264 import Encoder, can_encode
from talaia.gateway.video.pixels import Pixels
from talaia.wire import frames

from ...everyone.world import NOW
from .foxglove_peer import V1, NodeClient, client_of, topics_of

if TYPE_CHECKING:
    from collections.abc import Iterator

JPEG = b"\xff\xd8not looked at\xff\xd9"


async def test_picture_is_sent_as_a_compressed_image_only_while_somebody_subscribes(world) -> None:
    gateway = world.gateways["agv"]
    camera = await world.hub.camera()
    client = await client_of(world, "driver")
    topics = await topics_of(client)
    wanted = {"id": 4, "channelId": topics["/base/eye"]}
    await client.say({"op": "subscribe", "subscriptions": [wanted]})
    asked = await gateway.hear(frames.StreamSubscription, lambda asked: asked.streams)
    assert asked.forms == {"base/eye": ["jpeg"]}
    for number in (1, 2, 3):
        picture = frames.PictureFrame(
            stream="base/eye",
            seq=number,
            time_us=NOW + number,
            mono_us=number,
            width=4,
            height=4,
            forms=["jpeg"],
            data=JPEG,
        )
        await camera.say(picture)
        frame = await client.hear("data")
        assert frame[1:5] == b"\x04\0\0\0"
        said = json.loads(frame[13:])
        assert (said["format"], base64.b64decode(said["data"])) == ("jpeg", JPEG)
        assert said["timestamp"] == {"sec": NOW // 10**6, "nsec": number * 1000}
    await client.say({"op": "unsubscribe", "subscriptionIds": [4]})
    await gateway.hear(frames.StreamSubscription, lambda asked: not asked.streams)
    await client.close()


def pictures(count: int) -> Iterator[tuple[bytes, bool]]:
    """Encode a film that grows brighter as a gateway does: bytes, and whether it is a key."""
    encoder = Encoder(width=64, height=48, rate=10, bits=400_000)
    for number in range(count):
        rows = np.full((48, 64, 3), 40 * number, np.uint8)
        made = encoder.encode_picture(
            Pixels("RGB", 64, 48, rows), number * 100_000, key=number == 1
        )
        assert made is not None
        yield made.data, made.key


async def test_film_reaches_npms_client_from_its_first_key_frame_on_and_can_be_decoded(
    world,
) -> None:
    if not can_encode():
        pytest.skip("this PyAV has no x264")
    gateway, camera = world.gateways["agv"], await world.hub.camera()
    client = await client_of(world, "driver", kind=NodeClient, subprotocol=V1, coding="hex")
    async with client as it:
        channels = {one["topic"]: one for one in await it.hear("advertise")}
        video = channels["/base/eye/video"]
        assert (video["schemaName"], video["encoding"]) == ("foxglove.CompressedVideo", "json")
        await it.call("subscribe", video["id"])
        asked = await gateway.hear(frames.StreamSubscription, lambda asked: asked.streams)
        assert asked.forms == {"base/eye": ["h264"]}
        decoder, shades = av.CodecContext.create("h264", "r"), []
        film = list(pictures(5))
        # As if the client had come after the film began: the first is of no use to it.
        assert [key for _, key in film] == [True, True, False, False, False]
        for number, (data, key) in enumerate(film[2:3] + film[1:]):
            picture = frames.PictureFrame(
                stream="base/eye", seq=number + 1, time_us=NOW + number, mono_us=number + 1,
                width=64, height=48, format="h264", forms=["h264"], key=key, codec="avc1.42C00A",
                data=data,
            )  # fmt: skip
            await camera.say(picture)
            if number == 0:
                continue
            said = json.loads(bytes.fromhex((await it.hear("message"))["data"]))
            assert (said["format"], said["frame_id"]) == ("h264", "/base/eye")
            assert said["timestamp"]["nsec"] == number * 1000
            access_unit = base64.b64decode(said["data"])
            assert access_unit == data
            decoded = decoder.decode(av.Packet(access_unit))
            shades += [int(one.to_ndarray(format="gray").mean()) for one in decoded]
        shades += [int(one.to_ndarray(format="gray").mean()) for one in decoder.decode(None)]
        assert len(shades) == 4
        assert shades == sorted(set(shades))


async def test_camera_of_a_gateway_without_film_says_so_once_on_its_films_channel(world) -> None:
    gateway, camera = world.gateways["agv"], await world.hub.camera()
    client = await client_of(world, "driver")
    topics = await topics_of(client)
    wanted = [
        {"id": 4, "channelId": topics["/base/eye/video"]},
        {"id": 5, "channelId": topics["/base/eye"]},
    ]
    await client.say({"op": "subscribe", "subscriptions": wanted})
    await gateway.hear(frames.StreamSubscription, lambda asked: asked.streams)
    for number in (1, 2, 3):
        picture = frames.PictureFrame(
            stream="base/eye", seq=number, time_us=NOW, mono_us=number, width=4, height=4, data=JPEG
        )
        await camera.say(picture)
        await client.hear("data")
    said = await client.hear("status")
    assert said["message"] == (
        "the gateway of this camera makes no H.264; take /base/eye for its pictures"
    )
    # Unsubscribed, it rests; nothing else was said.
    await client.say({"op": "unsubscribe", "subscriptionIds": [4, 5]})
    await gateway.hear(frames.StreamSubscription, lambda asked: not asked.streams)
    kinds = [json.loads(frame)["op"] for frame in client.frames if isinstance(frame, str)]
    assert kinds.count("status") == 1
    await client.close()
