"""Programs of others that send by Socket.IO, of both generations, at a gateway."""

from __future__ import annotations

import asyncio
import base64
import itertools
import json
import ssl
from typing import TYPE_CHECKING, Any, NamedTuple

import httpx
import pytest
import pytest_asyncio
import simplejpeg
from certificates import Certificates
from fake_hub import FakeHub, fake_hub
from gateway_bench import addresses_of, running
from patience import LOOK_S, PATIENCE_S
from ports import free_port
from shared_trust import usual_trust

from talaia.wire.frames import DeviceState, Event, StreamSubscription

from ....hub.clients.socketio.socketio_peer import (
    CLIENTS,
    FoundingClient,
    NodeClient,
    PythonClient,
    RawClient,
)
from ...video.scenes import scene

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

pytestmark = pytest.mark.asyncio(loop_scope="module")

TOKEN = " ".join(["a", "secret", "of", "programs"])
SITE = """
talaia: 1
site: test
name: Test
connections:
  programs: {kind: socketio, port: PORT, token_file: TOKEN}
devices:
  vehicle:
    name: Vehicle
    signals:
      speed: {name: Speed, unit: m/s, source: {name: speed1}}
      far: {name: Far, unit: m, source: {namespace: sensedData, event: report, path: "echo[1]"}}
    streams:
      front: {name: Front, source: {}}
  weather:
    name: Weather
    signals:
      wind: {name: Wind, unit: m/s, source: {namespace: weather, path: wind}}
"""
# No two tests send the same.
VALUES = itertools.count(1)


class Bench(NamedTuple):
    """A gateway as its programs see it, and its hub."""

    port: int
    hub: FakeHub


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def bench(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Bench]:
    folder, port = tmp_path_factory.mktemp("gateway"), free_port()
    (folder / "token").write_text(TOKEN + "\n")
    text = SITE.replace("PORT", str(port)).replace("TOKEN", str(folder / "token"))
    async with fake_hub(addresses_of) as hub, running(hub.url, folder / "data", text):
        away = await hub.next(DeviceState, lambda state: state.device == "weather")
        assert not away.reached
        assert away.why == "no program that sends it is connected"
        yield Bench(port, hub)


async def program_of(bench: Bench, kind: type[Any], *namespaces: str, **more: Any) -> Any:
    return await kind().connect(bench, {"token": TOKEN}, list(namespaces), **more)


@pytest.mark.parametrize("kind", CLIENTS)
@pytest.mark.parametrize("transports", ["polling", "default"])
async def test_sensed_data_of_unchanged_programs_become_samples(
    bench: Bench, kind: type[Any], transports: str
) -> None:
    hub, value = bench.hub, float(next(VALUES))
    program = await program_of(bench, kind, "/sensedata", "/weather", transports=transports)
    async with program:
        await hub.next(DeviceState, lambda state: state.device == "weather" and state.reached)
        await program.say("/sensedata", "metric", {"name": "speed1", "magnitude": value})
        await program.say("/sensedata", "any", f"{{'name': 'speed1', 'magnitude': {value + 0.1}}}")
        packed = [{"data": f'{{"name": "speed1", "magnitude": "{value + 0.2}"}}'}]
        await program.say("/sensedata", "any", packed)
        wanted = [value, value + 0.1, value + 0.2]
        await hub.until(lambda: hub.values("vehicle/speed")[-3:] == wanted, "three ways to say it")
        await program.say("/sensedata", "other", {"echo": [7, -value]})
        await program.say("/sensedata", "report", {"echo": [7, value]})
        await program.say("/weather", "now", {"wind": value})
        await hub.until(lambda: hub.values("vehicle/far")[-1:] == [value], "a field of an event")
        await hub.until(lambda: hub.values("weather/wind")[-1:] == [value], "another namespace")
        assert -value not in hub.values("vehicle/far")
        answer = await program.ask("/sensedata", "metric", {"name": "speed1", "magnitude": 3})
        assert answer["accepted"] is True
        answer = await program.ask("/sensedata", "metric", {"name": "speed9", "magnitude": 3})
        assert answer["accepted"] is False
        assert "sensor 'speed9' of sensedData" in answer["reason"]
        # A key of control is no reading, and moves nothing.
        answer = await program.ask("/sensedata", "control", "w")
        assert "no commands are taken here" in answer["reason"]
    await hub.next(DeviceState, lambda state: state.device == "weather" and not state.reached)


@pytest.mark.parametrize("kind", [FoundingClient, PythonClient, NodeClient])
async def test_pictures_are_shown_while_somebody_looks(bench: Bench, kind: type[Any]) -> None:
    hub, picture = bench.hub, simplejpeg.encode_jpeg(scene(), 90)
    said: object = base64.b64encode(picture).decode()
    if kind is PythonClient:
        said = picture
    hub.pictures.clear()
    async with await program_of(bench, kind, "/cv2server") as program:
        await hub.send(StreamSubscription(streams=["vehicle/front"]))
        async with asyncio.timeout(PATIENCE_S):
            while not hub.pictures:
                answer = await program.ask("/cv2server", "frame", said)
                assert answer["accepted"] is True
        shown = hub.pictures[0]
        assert (shown.stream, shown.width, shown.height) == ("vehicle/front", 64, 48)
        await hub.send(StreamSubscription(streams=[]))


def told(hub: FakeHub, word: str) -> int:
    events = [event for event in hub.of(Event) if event.kind == "unreadable"]
    return sum(word in event.message for event in events)


async def test_new_sensor_is_told_once_and_bad_values_too(bench: Bench) -> None:
    hub = bench.hub
    async with await program_of(bench, PythonClient, "/sensedData") as program:
        for _ in range(3):
            await program.say("/sensedData", "metric", {"name": "heat7", "magnitude": 3})
            await program.say("/sensedData", "metric", {"name": "speed1", "magnitude": "fast"})
        why = await program.hear("refused")
        assert "sensor 'heat7'" in why
        answer = await program.ask("/sensedData", "metric", {"name": "speed1", "magnitude": 1})
        assert answer["accepted"] is True
        for word in ("heat7", "'fast'"):
            await hub.until(lambda word=word: told(hub, word), word)
            assert told(hub, word) == 1
        assert not [event for event in program.events if event[0] == "refused"]


async def test_configuration_names_what_is_read(bench: Bench) -> None:
    async with await program_of(bench, PythonClient, "/dynamicDB") as program:
        told = await program.hear("dynamicDB")
        assert told["sensors"] == ["speed1", "far", "wind"]
        assert told["units"]["speed1"] == "m/s"
        assert told["cameras"] == ["vehicle/front"]
        assert await program.ask("/dynamicDB", "list", None) == told


async def test_nobody_comes_in_without_the_token_or_from_a_page(bench: Bench) -> None:
    async with RawClient(bench, token=TOKEN[:-1]) as stranger:
        assert (await stranger.get()).status_code == 401
        refused = await bench.hub.next(Event, lambda event: event.kind == "socketio_refused")
        assert TOKEN[:-1] not in refused.message
    async with RawClient(bench, token=TOKEN) as page:
        assert (await page.get(headers={"Origin": "https://evil.test"})).status_code == 403
        assert (await page.get(EIO="5")).status_code == 400
        assert (await page.get(sid="guessed")).status_code == 400
    async with httpx.AsyncClient(trust_env=False, verify=usual_trust()) as other:
        address = f"http://127.0.0.1:{bench.port}/other?token={TOKEN}"
        assert (await other.get(address)).status_code == 404


async def test_a_program_that_falls_silent_keeps_its_place_for_a_quarter_of_a_minute(
    bench: Bench,
) -> None:
    async with RawClient(bench, token=TOKEN) as raw:
        told = json.loads((await raw.get()).text[1:])
        # Old and new clients go by these; `test_engine_connection` sees that we do.
        assert told["pingInterval"] + told["pingTimeout"] == 15_000
        # `socketIO-client` waits no longer than this for an answer to a poll.
        assert told["pingTimeout"] > told["pingInterval"]
        await raw.post("1", sid=told["sid"])


async def test_bodies_beyond_bounds_and_words_that_are_no_packets_end_one_program_alone(
    bench: Bench,
) -> None:
    async with await program_of(bench, PythonClient, "/sensedData") as program:
        async with RawClient(bench, token=TOKEN) as raw:
            await raw.connect()
            assert (await raw.post("4" + "x" * 1024 * 1024)).status_code == 413
            assert (await raw.post("this is none")).status_code == 400
            # Engine.IO's word that it is over.
            assert (await raw.get()).text == "1"
        answer = await program.ask("/sensedData", "metric", {"name": "speed1", "magnitude": 1})
        assert answer["accepted"] is True


async def test_programs_over_the_limit_are_told_and_the_others_go_on(bench: Bench) -> None:
    async with RawClient(bench, token=TOKEN) as raw:
        opened = []
        while (answer := await raw.get()).status_code == 200:
            opened.append(json.loads(answer.text[1:])["sid"])
        assert answer.status_code == 503
        assert 10 <= len(opened) <= 32
        # Each says that it goes.
        for sid in opened:
            assert (await raw.post("1", sid=sid)).status_code == 200
        async with asyncio.timeout(PATIENCE_S):
            while (await raw.get()).status_code != 200:  # noqa: ASYNC110 - it is another's answer
                await asyncio.sleep(LOOK_S)


async def test_programs_come_in_by_tls_where_there_is_a_certificate(tmp_path: Path) -> None:
    certificates, port = Certificates(tmp_path), free_port()
    (tmp_path / "token").write_text(TOKEN)
    chain = f"certificate: {certificates.cert}, key: {certificates.key}, token_file"
    text = SITE.replace("PORT", str(port)).replace("token_file", chain)
    text = text.replace("TOKEN", str(tmp_path / "token"))
    trust = ssl.create_default_context(cafile=str(certificates.ca))
    query = {"token": TOKEN, "EIO": "4", "transport": "polling"}
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", text):
        await hub.next(DeviceState, lambda state: state.device == "weather")
        async with httpx.AsyncClient(trust_env=False, verify=trust) as program:
            answer = await program.get(f"https://127.0.0.1:{port}/socket.io/", params=query)
            assert json.loads(answer.text[1:])["upgrades"] == ["websocket"]
            with pytest.raises(httpx.RemoteProtocolError):
                await program.get(f"http://127.0.0.1:{port}/socket.io/", params=query)
