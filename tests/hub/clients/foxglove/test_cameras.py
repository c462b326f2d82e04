"""Cameras as channels of a Foxglove client."""

from __future__ import annotations

import base64
import json

from talaia.wire import frames

from ...everyone.world import NOW
from .foxglove_peer import client_of, topics_of

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
