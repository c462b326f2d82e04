"""`talaia.client` at a real hub: as guest, driver, operator and admin; silence, losses, 1,000."""

from __future__ import annotations

import asyncio
import hashlib
import ssl
from contextlib import aclosing

import pyarrow as pa
import pyarrow.parquet
import pytest
from patience import PATIENCE_S

from talaia.client import (
    AsyncClient,
    BadSettings,
    Client,
    HistoryCut,
    HubNotReached,
    HubUntrusted,
    NotFound,
    NotPermitted,
    NotSignedIn,
    RequestRefused,
)
from talaia.wire import frames
from talaia.wire.certificate_der import public_key_of
from talaia.wire.frames import CommandPhase

from ...everyone.secure_hub import secure
from ...everyone.world import NOW
from ..tokens import token_of

pytestmark = pytest.mark.asyncio(loop_scope="module")

# What each may see of the site, written by hand: see `everyone.world`.
SEEN = {
    "guest": {"base/open"},
    "driver": {"base/open", "base/shut", "base/words"},
    "operator": {
        f"{device}/{name}"
        for device in ("base", "power", "camera")
        for name in ("open", "shut", "words")
    },
}
SEEN["admin"] = SEEN["operator"]


async def client_of(world, name) -> AsyncClient:
    return AsyncClient(world.hub.origin, await token_of(world.hub, name))


async def next_of(stream, where=lambda _found: True):
    async with asyncio.timeout(PATIENCE_S):
        async for found in stream:
            if where(found):
                return found
    raise AssertionError("it ended")


async def end_command(gateway, asked, phase, **more) -> None:
    await gateway.say(
        frames.CommandState(
            id=asked.id, device=asked.device, command=asked.command, phase=phase, **more
        )
    )


@pytest.mark.parametrize("name", SEEN)
async def test_client_lists_and_watches_what_its_person_may_see_and_nothing_else(
    shared_world, name
) -> None:
    client = await client_of(shared_world, name)
    sites = {site.site for site in await client.list_sites()}
    assert sites == ({"agv", "moon"} if name in {"operator", "admin"} else {"agv"})
    described = await client.describe_site("agv")
    found = {signal.address for device in described.devices for signal in device.signals}
    assert found == SEEN[name]
    await shared_world.gateways["agv"].samples(
        *((f"{device}/shut", NOW + 1, 7.0) for device in ("base", "power")),
        ("base/open", NOW + 1, 0.5),
    )
    async with aclosing(client.watch_values(["agv/*"], every_s=0)) as watch:
        await next_of(watch, lambda found: found.address == "agv/base/open")
    readings = await client.read_values(["agv/*"])
    assert {reading.address.removeprefix("agv/") for reading in readings} <= SEEN[name]
    if name == "guest":
        with pytest.raises(NotFound, match="no signal 'agv/base/shut'"):
            await client.read_values(["agv/base/shut"])
        with pytest.raises(NotFound):
            await client.read_history(["agv/base/shut"], since=0)
        with pytest.raises(NotFound, match="no site"):
            await client.read_values(["moon/rover/open"])
        with pytest.raises(NotPermitted, match="it takes the right use of agv/base"):
            await client.call_command("agv/base/turn")


async def test_what_a_person_got_wrong_is_told_with_what_to_do(shared_world) -> None:
    with pytest.raises(NotSignedIn, match="make another under Account"):
        await AsyncClient(shared_world.hub.origin, "tal_wrong").list_sites()
    with pytest.raises(NotSignedIn, match="make another under Account"):
        await AsyncClient(shared_world.hub.origin, "tal_wrong").read_values(["agv/base/open"])
    client = await client_of(shared_world, "operator")
    with pytest.raises(NotFound, match="did you mean agv/base/open"):
        await client.read_values(["agv/base/opne"])
    with pytest.raises(BadSettings, match="name the site before it, one of agv, moon"):
        await client.read_values(["base/open"])
    with pytest.raises(BadSettings, match="must be before"):
        await client.read_history(["agv/base/open"], since="now", until="1h")
    with pytest.raises(HubNotReached, match="cannot be reached"):
        await AsyncClient("http://127.0.0.1:1", "tal_x").list_sites()


async def test_value_that_gets_no_younger_is_told_as_stale_once_and_ends_with_the_next(
    shared_world,
) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "operator")
    await gateway.samples(("power/open", NOW + 5, 1.25))
    async with aclosing(client.watch_values(["agv/power/open"], every_s=0)) as watch:
        fresh = await next_of(watch, lambda found: found.value == 1.25)
        assert (fresh.stale, fresh.time.year) == ("", 2023)
        old = await next_of(watch)
        assert (old.stale, old.value) == ("older than 5 s", 1.25)
        assert old.age_s > 5
        await gateway.say(frames.DeviceState(device="power", reached=False, why="unplugged"))
        await gateway.samples(("power/open", NOW + 6, 2.5))
        assert (await next_of(watch)).value == 2.5


async def test_commands_are_asked_once_and_told_with_what_became_of_them(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "driver")
    heard, running = [], asyncio.Event()

    def report(progress) -> None:
        heard.append(progress)
        running.set()

    ends = [
        (CommandPhase.SUCCEEDED, "ok", "succeeded"),
        (CommandPhase.FAILED, "jammed", "failed"),
        (CommandPhase.REFUSED, "it rains", "refused"),
        (CommandPhase.UNKNOWN, "restarted", "unknown"),
    ]
    for phase, message, told in ends:
        call = asyncio.create_task(client.call_command("agv/base/turn", report=report))
        asked = await gateway.hear(frames.CommandRequest)
        assert (asked.device, asked.command, asked.who) == ("base", "turn", "driver")
        await end_command(gateway, asked, CommandPhase.RUNNING, progress=0.5)
        # One that ends at once is told by its end alone.
        await asyncio.wait_for(running.wait(), PATIENCE_S)
        running.clear()
        await end_command(gateway, asked, phase, message=message)
        result = await call
        assert (result.phase, result.message, result.id) == (told, message, asked.id)
        assert result.succeeded is (told == "succeeded")
    assert (heard[0].phase, heard[0].progress) == ("running", 0.5)
    refused = await client.call_command("agv/base/turn", {"far": 3.0})
    assert refused.phase == "refused"
    assert "far" in refused.message
    call = asyncio.create_task(client.call_command("agv/base/turn", timeout_s=0.3))
    asked = await gateway.hear(frames.CommandRequest)
    result = await call
    assert result.phase == "unknown"
    assert "look at the device before you ask again" in result.message
    await end_command(gateway, asked, CommandPhase.SUCCEEDED)
    assert not [each for each in gateway.heard if isinstance(each, frames.CommandRequest)]


async def test_command_whose_connection_is_lost_is_unknown_and_not_sent_again(
    shared_world,
) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "driver")
    call = asyncio.create_task(client.call_command("agv/base/turn"))
    asked = await gateway.hear(frames.CommandRequest)
    for connection in list(shared_world.hub._server.server_state.connections):
        if getattr(connection, "scope", {}).get("path") == "/ws":
            connection.transport.abort()
    result = await call
    assert (result.phase, result.id) == ("unknown", asked.id)
    assert "the connection to" in result.message
    assert "look at the device before you ask again" in result.message
    await end_command(gateway, asked, CommandPhase.SUCCEEDED)
    assert not [each for each in gateway.heard if isinstance(each, frames.CommandRequest)]


async def test_command_without_the_right_is_refused_with_the_right_that_it_takes(
    shared_world,
) -> None:
    client = AsyncClient(shared_world.hub.origin, shared_world.token)
    with pytest.raises(NotPermitted, match="it takes the right use of agv/base"):
        await client.call_command("agv/base/turn")


async def test_history_comes_as_arrow_whole_in_pieces_and_as_files(shared_world, tmp_path) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "operator")
    rows = [("camera/open", NOW + 10**9 + at, float(at)) for at in range(20_000)]
    before = gateway.sequence
    for begin in range(0, len(rows), 5000):
        await gateway.samples(*rows[begin : begin + 5000])
    await gateway.hear(frames.Ack, lambda ack: ack.below == before + len(rows))
    begin_s = (NOW + 10**9) / 1e6
    table = await client.read_history(["agv/camera/open"], begin_s, begin_s + 1)
    assert table.column_names == ["time", "camera/open"]
    assert table.column(1).to_pylist() == [float(at) for at in range(20_000)]
    asked = (["agv/camera/open"], begin_s, begin_s + 1)
    batches = [batch async for batch in client.stream_history(*asked)]
    assert pa.Table.from_batches(batches).equals(table)
    thinned = await client.read_history(*asked, width=10)
    assert 0 < thinned.num_rows < 200
    for form in ("parquet", "csv", "arrow"):
        size = await client.save_history(tmp_path / f"a.{form}", *asked, form=form)
        assert size == (tmp_path / f"a.{form}").stat().st_size
    assert pyarrow.parquet.read_table(tmp_path / "a.parquet").equals(table)
    assert [path.suffix for path in sorted(tmp_path.iterdir())] == [".arrow", ".csv", ".parquet"]


async def test_history_that_ends_before_its_end_is_an_error_and_leaves_no_file(tmp_path) -> None:
    async def answer(reader, writer) -> None:
        await reader.readuntil(b"\r\n\r\n")
        head = b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n"
        body = pa.BufferOutputStream()
        table = pa.table({"v": [1.0] * 1000})
        with pa.ipc.new_stream(body, table.schema) as stream:
            stream.write_table(table)
        said = body.getvalue().to_pybytes()[:-8]
        writer.write(head + f"{len(said):x}\r\n".encode() + said + b"\r\n")
        await writer.drain()
        writer.close()

    async with await asyncio.start_server(answer, "127.0.0.1", 0) as server:
        client = AsyncClient(f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}", "tal_x")
        with pytest.raises(HistoryCut):
            await client.read_history(["agv/base/open"], since=0)
        with pytest.raises(HistoryCut):
            await client.save_history(tmp_path / "a.csv", ["agv/base/open"], since=0, form="csv")
    assert list(tmp_path.iterdir()) == []


async def test_thousand_signals_are_watched_over_one_connection(hub_that_stores) -> None:
    signals = "".join(
        f"      s{at}: {{name: S{at}, source: {{topic: /t, type: std_msgs/msg/Float64,"
        " field: data}}\n"
        for at in range(1000)
    )
    described = (
        "talaia: 1\nsite: agv\nname: Many\nros2: {}\ndevices:\n  base:\n    name: Base\n"
        f"    signals:\n{signals}"
    )
    async with hub_that_stores() as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(described)
        gateway.channels = {f"base/s{at}": at for at in range(1000)}
        client = AsyncClient(hub.origin, await token_of(hub, "operator"))
        found = set()
        async with aclosing(client.watch_values(["base/*"], every_s=0)) as watch:
            first = asyncio.create_task(anext(watch))
            while not first.done():
                await gateway.samples(*((f"base/s{at}", NOW + 1, at) for at in range(1000)))
                await asyncio.wait([first], timeout=0.2)
            found.add((await first).address)
            await gateway.samples(*((f"base/s{at}", NOW + 2, at) for at in range(1000)))
            async with asyncio.timeout(PATIENCE_S):
                while len(found) < 1000:
                    found.add((await anext(watch)).address)
        assert len(await client.read_values(["base/*"])) == 1000


async def test_watch_outlives_the_hub_and_a_command_does_not(settings, hub_that_stores) -> None:
    said = []
    async with hub_that_stores() as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello()
        await gateway.samples(("base/speed", NOW + 1, 0.5))
        port, keys = hub.port, hub.keys
        client = AsyncClient(hub.origin, await token_of(hub, "operator"))
        watch = client.watch_values(["agv/base/speed"], report=said.append)
        assert (await next_of(watch)).value == 0.5
        name = (await client.describe_site("agv")).devices[0].commands[0]
        call = asyncio.create_task(
            client.call_command(f"agv/base/{name.id}", confirm=True, timeout_s=PATIENCE_S)
        )
        await gateway.hear(frames.CommandRequest)
    result = await call
    assert result.phase == "unknown"
    assert "was lost" in result.message
    lost = await next_of(watch)
    assert (lost.value, bool(lost.stale)) == (0.5, True)
    # The same hub again, at the same place.
    running = hub_that_stores()
    running.bind_port = port
    async with running as hub:
        hub.keys = keys
        gateway = await hub.gateway()
        await gateway.hello(boot="boot-2")
        back = asyncio.create_task(next_of(watch, lambda found: found.value == 0.75))
        at = 0
        while not back.done():
            at += 1
            await gateway.samples(("base/speed", NOW + 100 + at, 0.75))
            await asyncio.wait([back], timeout=0.2)
        assert (await back).stale == ""
        assert said[0].endswith("trying again")
        assert said[-1] == "connected again"
        assert not [each for each in gateway.heard if isinstance(each, frames.CommandRequest)]
        await watch.aclose()


async def test_hub_is_known_by_its_key_and_never_silently_trusted(
    settings, hub_that_stores
) -> None:
    async with secure(hub_that_stores, settings) as hub:
        token = await token_of(hub, "guest")
        certificate = settings.data / "tls" / "cert.pem"
        der = ssl.PEM_cert_to_DER_cert(certificate.read_text())
        for pin in (hashlib.sha256(der), hashlib.sha256(public_key_of(der))):
            client = AsyncClient(hub.origin, token, fingerprint=pin.hexdigest())
            assert await client.list_sites() == []
            with pytest.raises(NotFound):
                await client.read_values(["agv/base/open"])
        assert await AsyncClient(hub.origin, token, ca=certificate).list_sites() == []
        for wrong in (
            AsyncClient(hub.origin, token),
            AsyncClient(hub.origin, token, fingerprint="0" * 64),
        ):
            with pytest.raises(HubUntrusted):
                await wrong.list_sites()
            with pytest.raises(HubUntrusted):
                await wrong.press_stop("agv/base")


async def test_script_without_an_event_loop_reads_watches_and_calls(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    token = await token_of(shared_world.hub, "operator")
    await gateway.samples(("base/shut", NOW + 9, 1.5))

    def script():
        with Client(shared_world.hub.origin, token) as hub:
            seen = [site.site for site in hub.list_sites()]
            for reading in hub.watch_values(["agv/base/shut"]):
                seen.append(reading.address)
                break
            seen.append(hub.call_command("agv/base/turn").phase)
            return seen

    running = asyncio.create_task(asyncio.to_thread(script))
    asked = await gateway.hear(frames.CommandRequest)
    await end_command(gateway, asked, CommandPhase.SUCCEEDED)
    assert await running == ["agv", "moon", "agv/base/shut", "succeeded"]


async def test_recordings_are_begun_ended_and_refused_without_the_right(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "operator")
    states = [
        frames.RecorderState(on=False, problem="the disk is full"),
        frames.RecorderState(on=True, id="20260101T120000Z-a"),
        frames.RecorderState(on=False),
    ]
    begun = asyncio.create_task(client.start_recording("agv", why="a test"))
    asked = await gateway.hear(frames.RecordingRequest)
    assert (asked.on, asked.why, asked.who) == (True, "a test", "operator")
    await gateway.say(states[0])
    with pytest.raises(RequestRefused, match="the disk is full"):
        await begun
    # What failed before does not count for the next.
    begun = asyncio.create_task(client.start_recording("agv"))
    await gateway.hear(frames.RecordingRequest)
    await gateway.say(states[1])
    assert (await begun).id == "20260101T120000Z-a"
    ended = asyncio.create_task(client.stop_recording("agv"))
    assert not (await gateway.hear(frames.RecordingRequest)).on
    await gateway.say(states[2])
    assert not (await ended).on
    assert (await client.list_recordings("agv")).recordings == []
    with pytest.raises(NotFound, match="no recording 'none'"):
        await client.download_recording("agv", "none", "/nowhere/a.mcap")
    with pytest.raises(NotPermitted, match="it takes the right view of agv"):
        await (await client_of(shared_world, "driver")).start_recording("agv")
    assert not [one for one in gateway.heard if isinstance(one, frames.RecordingRequest)]


async def test_stop_is_confirmed_or_said_not_to_be(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "driver")
    pressing = asyncio.create_task(client.press_stop("agv/base"))
    stop = await gateway.hear(frames.StopRequest)
    await gateway.say(frames.StopState(device="base", latched=True, who="driver", id=stop.id))
    await pressing
    with pytest.raises(RequestRefused, match="robot's own stop"):
        await client.press_stop("agv/power")
