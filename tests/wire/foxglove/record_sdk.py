"""Records what foxglove-sdk's own server says, as the judge of our codec: run by hand.

python tests/wire/foxglove/record_sdk.py tests/wire/recorded/foxglove_sdk_v1.json
python tests/wire/foxglove/record_sdk.py --playback tests/wire/recorded/foxglove_sdk_playback.json
"""

from __future__ import annotations

import asyncio
import base64
import json
import struct
import sys
import threading
from pathlib import Path

import foxglove
import websockets
from foxglove.websocket import (
    Capability,
    MessageSchema,
    Parameter,
    PlaybackState,
    PlaybackStatus,
    ServerListener,
    Service,
    ServiceSchema,
    StatusLevel,
)

_SCHEMA = json.dumps({"type": "object", "properties": {"value": {"type": "number"}}})


class Listener(ServerListener):
    """Answers with one parameter, and knows when its client has subscribed."""

    def __init__(self) -> None:
        """Wait for a subscription."""
        self.subscribed = threading.Event()

    def on_subscribe(self, _client, _channel):
        self.subscribed.set()

    def on_get_parameters(self, _client, _names, _request_id=None):
        return [Parameter("speed", value=1.5)]


def _answer(request) -> bytes:
    if b"fail" in request.payload:
        raise RuntimeError("it failed")
    return b'{"done": true}'


def _services() -> list[Service]:
    request = MessageSchema(
        encoding="json",
        schema=foxglove.Schema(name="Ask", encoding="jsonschema", data=_SCHEMA.encode()),
    )
    schema = ServiceSchema(name="std_srvs/Trigger", request=request, response=request)
    return [Service(name="/base/turn", schema=schema, handler=_answer)]


async def record(subprotocol: str) -> list[dict[str, str]]:
    """Serve on a free port, talk as a client and keep every frame both ways."""
    listener = Listener()
    server = foxglove.start_server(
        name="recorded",
        host="127.0.0.1",
        port=0,
        capabilities=[
            Capability.ClientPublish,
            Capability.ConnectionGraph,
            Capability.Parameters,
            Capability.Services,
            Capability.Time,
        ],
        supported_encodings=["json"],
        services=_services(),
        asset_handler=lambda uri: b"mesh" if uri == "package://robot/mesh.stl" else None,
        server_listener=listener,
        session_id="recorded",
    )
    schema = foxglove.Schema(name="Speed", encoding="jsonschema", data=_SCHEMA.encode())
    channel = foxglove.Channel("/base/speed", schema=schema, message_encoding="json")
    frames: list[dict[str, str]] = []

    def keep(side: str, frame: bytes | str) -> None:
        if isinstance(frame, bytes):
            frames.append({"from": side, "bytes": base64.b64encode(frame).decode()})
        else:
            frames.append({"from": side, "text": frame})

    async with websockets.connect(
        f"ws://127.0.0.1:{server.port}", subprotocols=[subprotocol], proxy=None
    ) as client:

        async def hear(count: int) -> None:
            for _ in range(count):
                keep("server", await asyncio.wait_for(client.recv(), 5))

        async def say(frame: bytes | dict[str, object]) -> None:
            sent = json.dumps(frame) if isinstance(frame, dict) else frame
            keep("client", sent)
            await client.send(sent)

        await hear(3)
        first = next(json.loads(f["text"]) for f in frames if '"advertise"' in f.get("text", ""))
        number = first["channels"][0]["id"]
        await say({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": number}]})
        await asyncio.to_thread(listener.subscribed.wait, 5)
        channel.log({"value": 2.5}, log_time=1_700_000_000_123_456_789)
        await hear(1)
        server.broadcast_time(1_700_000_000_000_000_001)
        await hear(1)
        server.publish_status("look out", StatusLevel.Warning, "an id")
        await hear(1)
        server.remove_status(["an id"])
        await hear(1)
        await say({"op": "getParameters", "parameterNames": [], "id": "p1"})
        await hear(1)
        await say({"op": "fetchAsset", "uri": "package://robot/mesh.stl", "requestId": 5})
        await hear(1)
        await say({"op": "fetchAsset", "uri": "package://robot/none", "requestId": 6})
        await hear(1)
        for call, payload in ((1, b"{}"), (2, b"fail")):
            await say(struct.pack("<BIII", 2, 1, call, 4) + b"json" + payload)
            await hear(1)
        await say({"op": "subscribeConnectionGraph"})
        await hear(1)
        graph = foxglove.ConnectionGraph()
        graph.set_published_topic("/base/speed", ["base"])
        graph.set_advertised_service("/base/turn", ["base"])
        server.publish_connection_graph(graph)
        await hear(1)
        await say({"op": "unsubscribe", "subscriptionIds": [7]})
        channel.close()
        await hear(1)
        server.remove_services(["/base/turn"])
        await hear(1)
        await say({"op": "nonsense"})
        await hear(1)
    server.stop()
    return frames


class Player(ServerListener):
    """Answers as if it did what it is asked, and writes down what the SDK understood."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.understood: list[dict[str, object]] = []

    def on_playback_control_request(self, request):
        self.understood.append(
            {
                "command": str(request.playback_command),
                "speed": request.playback_speed,
                "seek": request.seek_time,
                "id": request.request_id,
            }
        )
        return PlaybackState(
            status=PlaybackStatus.Playing,
            current_time=1_700_000_000_123_456_789,
            playback_speed=request.playback_speed,
            did_seek=request.seek_time is not None,
            request_id=request.request_id,
        )


async def record_playback() -> list[dict[str, object]]:
    """Serve a window, ask for its playing and keep every frame both ways."""
    player = Player()
    server = foxglove.start_server(
        name="recorded",
        host="127.0.0.1",
        port=0,
        capabilities=[Capability.PlaybackControl, Capability.Time],
        server_listener=player,
        playback_time_range=(1_700_000_000_000_000_001, 1_700_000_100_000_000_002),
        session_id="recorded",
    )
    frames: list[dict[str, object]] = []
    address = f"ws://127.0.0.1:{server.port}"
    async with websockets.connect(address, subprotocols=["foxglove.sdk.v1"], proxy=None) as client:
        frames.append({"from": "server", "text": await client.recv()})
        for command, speed, seek in ((0, 2.0, None), (1, 0.5, 1_700_000_050_000_000_000)):
            number = f"request-{command}".encode()
            head = (3, command, speed, seek is not None, seek or 0, len(number))
            asked = struct.pack("<BBfBQI", *head) + number
            frames.append({"from": "client", "bytes": base64.b64encode(asked).decode()})
            await client.send(asked)
            said = await asyncio.wait_for(client.recv(), 5)
            frames.append({"from": "server", "bytes": base64.b64encode(said).decode()})
            frames[-2]["understood"] = player.understood[-1]
        server.broadcast_playback_state(
            PlaybackState(
                status=PlaybackStatus.Ended,
                current_time=99,
                playback_speed=1.0,
                did_seek=False,
                request_id=None,
            )
        )
        said = await asyncio.wait_for(client.recv(), 5)
        frames.append({"from": "server", "bytes": base64.b64encode(said).decode()})
    server.stop()
    return frames


if __name__ == "__main__":
    played = "--playback" in sys.argv
    recorded = asyncio.run(record_playback() if played else record("foxglove.sdk.v1"))
    Path(sys.argv[-1]).write_text(json.dumps(recorded, indent=1, ensure_ascii=False) + "\n")
