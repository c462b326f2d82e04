"""Socket.IO clients of both generations at a real hub, as guest, operator of a device and admin."""

from __future__ import annotations

import asyncio
import base64
import itertools
import json

import pytest
import websockets
from patience import LOOK_S, PATIENCE_S

from talaia.wire import frames
from talaia.wire.frames import LeaseOp

from ...everyone.world import NOW
from ..tokens import open_protocol, token_of
from .socketio_peer import (
    CLIENTS,
    FoundingClient,
    NodeClient,
    OldNodeClient,
    PythonClient,
    RawClient,
    client_of,
)

pytestmark = pytest.mark.asyncio(loop_scope="module")

# Rising from one test to the next, as at a robot: microseconds.
TIMES = itertools.count(NOW, 10**7)

# What each may see of the site, written by hand: see `everyone.world`.
DEVICES = ("base", "power", "camera")
SENSORS = {
    "guest": {"base/open": "open"},
    "driver": {"base/open": "open", "base/shut": "shut", "base/words": "words"},
    # Three devices have signals of the same names, which tell nothing then.
    "admin": {
        address: address
        for device in DEVICES
        for address in (f"{device}/open", f"{device}/shut", f"{device}/words")
    },
}
CAMERAS = {"guest": [], "driver": ["base/eye"], "admin": [f"{device}/eye" for device in DEVICES]}
VEHICLES = {"guest": [], "driver": ["base"], "admin": list(DEVICES)}


async def until(ask, holds):
    """Ask until the answer is as it should be; give it."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            answer = await ask()
            if holds(answer):
                return answer
            await asyncio.sleep(LOOK_S)


@pytest.mark.parametrize("kind", CLIENTS)
@pytest.mark.parametrize("name", SENSORS)
async def test_client_is_told_what_its_person_may_see_and_nothing_else(
    shared_world, name, kind
) -> None:
    gateway = shared_world.gateways["agv"]
    turn = CLIENTS.index(kind) * 10 + list(SENSORS).index(name)
    # The last of the public signal is heard by everybody, after all that comes before it.
    now = next(TIMES)
    rows = [
        (address, now, f"said-{address}" if "words" in address else turn + 0.25)
        for address in sorted(SENSORS["admin"], key=lambda address: address == "base/open")
    ]
    async with await client_of(shared_world, name, kind, "/dynamicDB", "/sensedData") as client:
        told = await client.hear("dynamicDB")
        assert told["sensors"] == list(SENSORS[name].values())
        assert (told["cameras"], told["vehicles"]) == (CAMERAS[name], VEHICLES[name])
        assert await client.ask("/dynamicDB", "anything") == told
        await gateway.samples(*rows)
        wanted = {
            SENSORS[name][address]: value for address, _, value in rows if address in SENSORS[name]
        }
        for sensor, value in wanted.items():
            metric = {"name": sensor, "magnitude": value}
            await client.hear("sensedData", lambda said, metric=metric: said == metric)
        # All that came, of this turn or of what was known before, is of theirs.
        heard = [data for event, _, data in client.events if event == "sensedData"]
        assert {metric["name"] for metric in heard} <= wanted.keys()
        assert {event for event, _, _ in client.events} <= {"sensedData", "connect"}


@pytest.mark.parametrize(
    ("kind", "transports"),
    [
        (kind, transports)
        for kind in CLIENTS
        for transports in ("default", "polling", "websocket")
        # socketIO-client always begins by polling.
        if (kind, transports) != (FoundingClient, "websocket")
    ],
)
async def test_each_transport_carries_events_both_ways(shared_world, kind, transports) -> None:
    founding = kind is FoundingClient
    gateway = shared_world.gateways["agv"]
    async with await client_of(
        shared_world, "guest", kind, "/sensedata", transports=transports
    ) as client:
        # socketIO-client asks to upgrade with two headers `Connection`; uvicorn heeds the last.
        wanted = "polling" if transports == "polling" or founding else "websocket"
        await until(client.transport, lambda said: said.endswith(wanted))
        now = next(TIMES)
        value = 100 + now % 10**9 / 10**6
        await gateway.samples(("base/open", now, value))
        await client.hear("sensedata", lambda said: said == {"name": "open", "magnitude": value})
        # More than one answer of a poll holds.
        await gateway.samples(*(("base/open", now + at, value + at) for at in range(1, 60)))
        await client.hear("sensedata", lambda said: said["magnitude"] == value + 59)
        answer = await client.ask("/sensedata", "metric", {"name": "speed1", "magnitude": 1.4})
        assert answer["accepted"] is False
        assert "send them to the robot's gateway" in answer["reason"]


async def permit(world, device: str, *, allowed: bool) -> None:
    admin = await world.admin()
    person = (await world.hub.people.find_by_name("driver")).id
    asked = {"person": str(person), "site": "agv", "device": device, "allowed": allowed}
    assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204


@pytest.mark.parametrize("kind", CLIENTS)
async def test_character_drives_once_an_admin_permits_it_and_s_stands_still(
    shared_world, kind
) -> None:
    gateway = shared_world.gateways["agv"]
    async with await client_of(shared_world, "driver", kind, "/cv2server") as client:
        await client.say("/cv2server", "control", "w")
        assert "an admin may let your account" in await client.hear("refused")
        # Without leave to drive, what is to stand still is stopped.
        await client.say("/cv2server", "control", "s")
        stop = await gateway.hear(frames.StopRequest)
        await gateway.say(frames.StopState(device="base", latched=True, who="driver", id=stop.id))
        await permit(shared_world, "base", allowed=True)
        assert await client.ask("/cv2server", "control", ["x"]) == {"accepted": True, "reason": ""}
        lease = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.TAKE)
        assert lease.who == "driver"
        epoch = 100 + CLIENTS.index(kind)
        await gateway.say(
            frames.LeaseState(
                device="base", session=lease.session, who="driver", epoch=epoch, remains_ms=3000
            )
        )
        await gateway.say(frames.ControlTick(tick=42))

        async def keep_driving() -> None:
            while True:
                await client.say("/cv2server", "anything", "x")
                await asyncio.sleep(0.05)

        driving = asyncio.create_task(keep_driving())
        moved = await gateway.hear(
            frames.DriveFrame, lambda frame: frame.epoch == epoch and frame.linear < 0
        )
        driving.cancel()
        # Half of the description's 1 m/s.
        assert (moved.linear, moved.angular) == (-0.5, 0.0)
        await client.say("/cv2server", "s")
        zero = await gateway.hear(
            frames.DriveFrame, lambda frame: frame.epoch == epoch and frame.linear == 0
        )
        assert zero.seq > moved.seq
        # The word, whatever else is so.
        await client.say("/cv2server", "stop")
        stop = await gateway.hear(frames.StopRequest, lambda stop: stop.who == "driver")
        await gateway.say(frames.StopState(device="base", latched=True, who="driver", id=stop.id))
        await gateway.hear(
            frames.LeaseRequest,
            lambda ask: ask.op is LeaseOp.FREE and ask.session == lease.session,
        )
        await permit(shared_world, "base", allowed=False)


async def test_guest_drives_stops_and_sees_nothing_whatever_it_asks(shared_world) -> None:
    wishes = {"vehicle": "base", "camera": "base/eye"}
    async with await client_of(
        shared_world, "guest", NodeClient, "/server2web", **wishes
    ) as client:
        assert "no camera 'base/eye'" in await client.hear("refused")
        for said in ("w", "s", "stop"):
            answer = await client.ask("/server2web", "control", said)
            assert (answer["accepted"], "nothing here" in answer["reason"]) == (False, True)
        assert not [event for event, _, _ in client.events if event == "server2web"]


async def test_who_may_drive_several_says_which(shared_world) -> None:
    async with await client_of(shared_world, "admin", PythonClient, "/dynamicDB") as client:
        answer = await client.ask("/dynamicDB", "control", "w")
        assert "vehicle=" in answer["reason"]
    async with await client_of(
        shared_world, "admin", PythonClient, "/dynamicDB", vehicle="power"
    ) as client:
        answer = await client.ask("/dynamicDB", "control", "w")
        assert answer["reason"].startswith("power is driven from Talaia's own pages only")


def forget_subscriptions(gateway) -> None:
    """Forget what was asked of the gateway's cameras before, such as nothing when one came."""
    gateway.heard[:] = [
        said for said in gateway.heard if not isinstance(said, frames.StreamSubscription)
    ]


JPEG = b"\xff\xd8not looked at\xff\xd9"
BASE64 = base64.b64encode(JPEG).decode()


@pytest.mark.parametrize(
    ("kind", "pictures", "transports"),
    [
        (FoundingClient, "base64", "default"),
        (OldNodeClient, "bytes", "polling"),
        (OldNodeClient, "bytes", "websocket"),
        (PythonClient, "bytes", "polling"),
        (NodeClient, "bytes", "default"),
        (NodeClient, "base64", "polling"),
    ],
)
async def test_picture_is_sent_as_it_is_wished_only_while_somebody_is_there(
    shared_world, kind, pictures, transports
) -> None:
    gateway = shared_world.gateways["agv"]
    camera = await shared_world.hub.camera()
    forget_subscriptions(gateway)
    async with await client_of(
        shared_world, "driver", kind, "/server2web", transports=transports, pictures=pictures
    ) as client:
        asked = await gateway.hear(frames.StreamSubscription, lambda asked: asked.streams)
        assert asked.forms == {"base/eye": ["jpeg"]}
        for number in (1, 2, 3):
            await camera.say(
                frames.PictureFrame(
                    stream="base/eye",
                    seq=number,
                    time_us=NOW + number,
                    mono_us=number,
                    width=4,
                    height=4,
                    # For all: on a busy machine the small form may be wished for by now.
                    forms=[],
                    data=JPEG,
                )
            )
            heard = await client.hear("server2web")
            assert heard == (BASE64 if pictures == "base64" else {"bytes": BASE64})
        forget_subscriptions(gateway)
    await gateway.hear(frames.StreamSubscription, lambda asked: not asked.streams)


async def test_events_have_the_name_that_the_address_wishes(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    async with await client_of(
        shared_world, "guest", FoundingClient, "/sensedData", event="metric"
    ) as client:
        await gateway.samples(("base/open", next(TIMES), 7.5))
        await client.hear("metric", lambda said: said["magnitude"] == 7.5)


async def test_namespace_that_there_is_not_is_refused_to_both_generations(shared_world) -> None:
    hub = shared_world.hub
    await open_protocol(hub, "socketio")
    token = await token_of(hub, "guest")
    for revision, refusal in (("3", '44/other,"Invalid'), ("4", '44/other,{"message":"Invalid')):
        address = f"ws://127.0.0.1:{hub.port}/socket.io/?EIO={revision}&transport=websocket"
        async with websockets.connect(f"{address}&site=agv&token={token}", proxy=None) as socket:
            await socket.send("40/other,")
            async with asyncio.timeout(PATIENCE_S):
                while not (said := await socket.recv()).startswith("44"):
                    pass
            assert said.startswith(refusal)


async def test_only_a_good_token_opens_it_and_only_from_named_origins(shared_world) -> None:
    hub = shared_world.hub
    token = await token_of(hub, "operator")
    await open_protocol(hub, "socketio", "https://tools.example")
    async with RawClient(hub) as raw:
        tried = [
            (await raw.get(headers=headers, **query)).status_code
            for headers, query in (
                ({}, {}),
                ({}, {"token": f"tal_{'x' * 43}"}),
                ({"Cookie": await hub.cookie("admin")}, {}),
                ({"Origin": "https://evil.test"}, {"token": token}),
                ({"Origin": "null"}, {"token": token}),
                ({}, {"token": token, "site": "nowhere"}),
                ({}, {"token": token, "site": ""}),
                ({}, {"token": token, "EIO": "2"}),
                ({}, {"token": token, "pictures": "png"}),
                ({"Authorization": f"Bearer {token}"}, {}),
            )
        ]
        assert tried == [401, 401, 401, 403, 403, 404, 400, 400, 400, 200]
        named = await raw.get(headers={"Origin": "https://tools.example"}, token=token)
        assert named.headers["access-control-allow-origin"] == "https://tools.example"
        await open_protocol(hub, "socketio", is_open=False)
        assert (await raw.get(token=token)).status_code == 403
        assert (await raw.post("40", token=token, sid="x")).status_code == 403
    socket = f"ws://127.0.0.1:{hub.port}/socket.io/?EIO=4&transport=websocket&token={token}"
    with pytest.raises(websockets.InvalidStatus) as refused:
        await websockets.connect(socket, proxy=None)
    assert refused.value.response.status_code == 403


async def test_session_is_of_its_account_alone_and_of_one_poll_at_a_time(shared_world) -> None:
    hub = shared_world.hub
    await open_protocol(hub, "socketio")
    async with RawClient(hub, token=await token_of(hub, "operator")) as mine:
        await mine.connect()
        async with RawClient(
            hub, token=await token_of(hub, "guest"), sid=mine.query["sid"]
        ) as other:
            assert (await other.get()).status_code == 400
            assert (await other.post("40/sensedData,")).status_code == 400
        assert (await mine.post("40/sensedData,")).status_code == 200
        assert '40/sensedData,{"sid":' in (await mine.get()).text
        await mine.post("41/sensedData,")
        waiting = asyncio.create_task(mine.get())
        second = await mine.get()
        first = await waiting
        assert sorted((first.status_code, second.status_code)) in ([200, 400], [400, 400])
        assert (await mine.get()).status_code == 400


@pytest.mark.parametrize(
    "body", ["x", "4{", "47", "42[]", "4bAA", "b4", "0", "5", "4" + "2" * 10**6]
)
async def test_nonsense_ends_the_session_and_nothing_else(shared_world, body) -> None:
    hub = shared_world.hub
    await open_protocol(hub, "socketio")
    async with RawClient(hub, token=await token_of(hub, "guest")) as raw:
        await raw.connect()
        await raw.post(body)
        async with asyncio.timeout(PATIENCE_S):
            while (await raw.get()).status_code == 200:
                pass
        del raw.query["sid"]
        await raw.connect()


async def test_account_that_is_disabled_ends_its_polled_session(
    shared_world,
) -> None:
    hub = shared_world.hub
    await open_protocol(hub, "socketio")
    admin = await shared_world.admin()
    person = (await hub.people.find_by_name("guest")).id
    async with RawClient(hub, token=await token_of(hub, "guest")) as raw:
        await raw.connect()
        await raw.post("40/sensedData,")
        try:
            answer = await admin.patch(f"/api/people/{person}", json={"disabled": True})
            assert answer.status_code == 200
            sessions = lines_of(hub)

            async def is_closed() -> bool:
                line = sessions.get(raw.query["sid"])
                return line is None or line.is_closed

            await until(is_closed, bool)
            assert (await raw.get()).status_code == 401
        finally:
            await admin.patch(f"/api/people/{person}", json={"disabled": False})


async def test_client_of_a_protocol_that_is_shut_ends_and_is_told_why(shared_world) -> None:
    hub = shared_world.hub
    await open_protocol(hub, "socketio")
    async with await client_of(shared_world, "guest", PythonClient, "/sensedData") as client:
        await open_protocol(hub, "socketio", is_open=False)
        await client.hear("disconnect")
        await client.hear("refused", lambda said: "has shut this protocol" in said)
    assert hub.hub.client_protocols.protocols.count_connected("socketio") == 0


def lines_of(hub) -> dict:
    """Give the open sessions by their names."""
    (feature,) = (feature for feature in hub.hub.clients if feature.name == "socketio")
    return feature._sessions._lines


async def test_client_that_does_not_poll_costs_a_bounded_line_and_delays_nobody(
    shared_world,
) -> None:
    hub, gateway = shared_world.hub, shared_world.gateways["agv"]
    await open_protocol(hub, "socketio")
    async with RawClient(hub, token=await token_of(hub, "operator")) as slow:
        await slow.connect()
        await slow.post("40/sensedData,")
        line = lines_of(hub)[slow.query["sid"]]
        async with await client_of(shared_world, "operator", PythonClient, "/sensedData") as quick:
            for turn in range(20):
                now = next(TIMES)
                text = f"{turn} " + "x" * 1900
                rows = [("base/words", now + at, text) for at in range(200)]
                await gateway.samples(*rows)
                await quick.hear("sensedData", lambda said, text=text: said["magnitude"] == text)
            # One message may stand over what lets the next wait: a batch of the hub's.
            assert line.waiting_bytes < 2 * 1024 * 1024
            waiting = [
                browser.waiting for browser in hub.hub.core.browsers if browser.form == "object"
            ]
            assert max(waiting) < 8 * 1024 * 1024


async def test_who_comes_and_goes_is_written_down(shared_world) -> None:
    async with await client_of(shared_world, "driver", PythonClient, "/dynamicDB"):
        pass
    admin = await shared_world.admin()

    async def entries() -> list[dict]:
        return (await admin.get("/api/audit")).json()["rows"]

    def is_left(entry) -> bool:
        said = (entry["kind"], entry["who"], entry["message"])
        return said == ("client disconnected", "driver", "Socket.IO")

    found = await until(entries, lambda rows: any(map(is_left, rows)))
    assert "tal_" not in json.dumps(found)
