"""The faults, one row each: what is done to the world, and what must hold.

Long, because the rows are read beside each other, as in the table that they fill.
"""

from __future__ import annotations

import asyncio
import contextlib
import random
import shutil
import signal
import time
from collections.abc import Awaitable, Callable
from typing import NamedTuple

import httpx
import websockets
from patience import lasts_for
from shared_trust import usual_trust

from talaia.wire import browser, frames

from ..people import Page, connection, page, sign_in
from ..stack import Process, until
from . import ledgers
from .crashing import POINTS
from .doing import back, pause, sees_values
from .ledgers import MS, Findings
from .postgres import postgres
from .rows_crowd import f16, f17, f18
from .rows_state import f10, f25, f30, long_partition, reset
from .weather import Way, Weather
from .world import CRASHING, SITE, Run, World, now, small_disk, under_load

# Long enough for a link that is dark to be lost, and what is heard meanwhile to be on disk only.
DOWN_S = 0.5
# Three beats, a second apart, each given a second for its answer.
BEATS_S = 4.0
# The machine is shared.
BEATS_LATE_S = 1.0
# Who stands still for longer may have lost the connection that it had.
FAREWELL_S = 10.0
# Without its database a hub takes a driver at his word for so long (`Settings.unsure_s`), and
# looks so often.
UNSURE_S = 2.0
CHECKED_S = 1.0


async def f1(world: World, chance: random.Random, findings: Findings) -> None:
    """`kill -9` the hub while it stores and somebody drives."""
    async with under_load(world, findings) as run:
        async with page(world, "driver") as driver:
            await run.press(driver)
            await run.mark(driver)
            await pause(chance)
            links = world.links
            at = world.hub.kill()
            await run.stopped(at)
        await run.turn_door()
        world.start_hub()
        await world.hub.says("ready")
        async with back(findings):
            await world.linked_again(links)
        await run.let_go()
        run.nothing_moves_after(at)


async def f2(world: World, chance: random.Random, findings: Findings) -> None:
    """`kill -9` the gateway; the robot is left to its own time-out."""
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        await run.mark(driver)
        await pause(chance, 0.4, 0.8)
        knew = world.said()[-1].known
        # Its own end comes between what it heard and the hub.
        world.proxy.change(Weather(dark=frozenset(Way)))
        await run.turn_door()
        await lasts_for(DOWN_S)
        killed = world.gateway.kill()
        world.proxy.cut()
        world.proxy.change(Weather())
        world.start_gateway()
        async with back(findings):
            await world.ready()
            await until(lambda: world.said()[-1].known > knew, 30, "the robot knows the gateway")
        await lasts_for(0.5)
        # The finger is still on the key, and nobody has the lease.
        run.nothing_moves_after(killed)


async def f4(world: World, chance: random.Random, findings: Findings) -> None:
    """Crash at a named point, from commit to the spool's rotation."""
    # In turn, so that a run of as many seeds as there are points has been through all of them.
    point = sorted(POINTS)[findings.turn % len(POINTS)]
    findings.counted[point] += 1
    if point.startswith("spool"):
        await _crash_gateway(world, point, chance, findings)
    elif point == "hub-mid-migration":
        await _crash_migration(world, findings)
    elif "description" in point:
        await _crash_description(world, point, findings)
    else:
        await _crash_hub(world, point, findings)


async def _dies(process: Process, within: float) -> None:
    await until(lambda: process.popen.poll() is not None, within, "the crash at the named point")
    assert process.popen.returncode == -signal.SIGKILL, process.said()
    process.end()


async def _crash_hub(world: World, point: str, findings: Findings) -> None:
    async with under_load(world, findings) as run:
        links = world.links
        world.hub.kill()
        world.crash["hub"] = point
        try:
            hub = world.start_hub()
            await _dies(hub, 30)
        finally:
            world.crash["hub"] = ""
        await run.turn_door()
        world.start_hub()
        await world.hub.says("ready")
        async with back(findings):
            await world.linked_again(links)


async def _crash_description(world: World, point: str, findings: Findings) -> None:
    """A hub that dies over a changed description has the old one or the new one, and goes on."""
    world.gateway.end()
    file = world.folder / "site.yaml"
    name = f"Faults {now()}"
    file.write_text(world.description.replace("name: Faults", f"name: {name}", 1))
    world.hub.kill()
    world.crash["hub"] = point
    try:
        hub = world.start_hub()
        await hub.says("ready")
        world.start_gateway()
        await _dies(hub, 30)
    finally:
        world.crash["hub"] = ""
    world.start_hub()
    await world.hub.says("ready")
    async with back(findings):
        await world.ready()
    async with httpx.AsyncClient(base_url=world.address, verify=usual_trust()) as client:
        answer = await client.get("/api/sites", headers={"Cookie": await world.cookie()})
    if name not in answer.text:
        findings.breach("F4", f"the description that came is not shown: {answer.text[:300]}")
    async with under_load(world, findings):
        await lasts_for(0.5)


async def _crash_migration(world: World, findings: Findings) -> None:
    """A hub that dies between two steps starts well the next time, on a folder of its own."""
    folder = world.folder / f"migrated-{now()}"
    folder.mkdir()
    words = ["hub", "--data", str(folder), "--plain", "--host", "127.0.0.1", "--port", "0"]
    dying = Process(
        [str(CRASHING), *words], folder / "hub.log", {"TALAIA_CRASH_AT": "hub-mid-migration"}
    )
    await _dies(dying, 30)
    whole = Process(["-m", "talaia", *words], folder / "hub.log", {})
    try:
        async with back(findings):
            await whole.says("ready")
    finally:
        whole.end()


async def _crash_gateway(
    world: World, point: str, chance: random.Random, findings: Findings
) -> None:
    """The link is dark, so that the spool fills, closes segments and lets the oldest go."""
    removal = "removal" in point
    kept = world.gateway_data
    async with under_load(world, findings) as run:
        world.gateway.end()
        # A folder of its own, so that what is removed is not what an earlier run has left.
        world.gateway_data = world.folder / f"crash-{now()}"
        world.more_words = ["--spool-mb", "0.03" if removal else "0.3"]
        world.crash["gateway"] = point
        try:
            knew = world.said()[-1].known
            gateway = world.start_gateway()

            def heard() -> bool:
                return "linked to" in gateway.said() and world.said()[-1].known > knew

            await until(
                lambda: heard() or gateway.popen.poll() is not None, 30, "the gateway listens"
            )
            early = not heard()
            # What was said while there was none is nobody's to keep.
            await run.begin_anew()
            world.proxy.change(Weather(dark=frozenset(Way)))
            await _dies(gateway, 60)
            knew = world.said()[-1].known
        finally:
            world.crash["gateway"], world.more_words = "", []
        world.proxy.cut()
        await pause(chance)
        world.proxy.change(Weather())
        world.start_gateway()
        async with back(findings):
            await world.ready()
            if not early:
                await until(lambda: world.said()[-1].known > knew, 30, "the robot knows it")
        if early:
            # It died over what an earlier run had left, before the robot knew of it.
            findings.counted["before the robot knew it"] += 1
            await lasts_for(1.0)
            await run.begin_anew()
            # Nobody may have heard it.
            await run.turn_door()
        await lasts_for(0.3)
    world.gateway.end()
    world.gateway_data = kept


# Short ones first: a run of as many seeds as there are has been through all of them.
FREEZES = [(each, s) for s in (1.0, 5.0, 30.0) for each in ("hub", "gateway", "database")]


async def f5(world: World, chance: random.Random, findings: Findings) -> None:
    """SIGSTOP, then SIGCONT: a process that wakes up must not do what is old."""
    short = [each for each in FREEZES if each[1] == 1.0]
    which, seconds = (FREEZES if world.long else short)[
        findings.turn % len(FREEZES if world.long else short)
    ]
    findings.counted[f"{which} {seconds:g} s"] += 1
    if which == "database":
        await _freeze_database(world, seconds, chance, findings)
        return
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        await run.mark(driver)
        await pause(chance)
        process = (world.hub if which == "hub" else world.gateway).popen
        at = now()
        process.send_signal(signal.SIGSTOP)
        try:
            if which == "hub":
                await run.turn_door()
            await lasts_for(seconds)
            await run.let_go()
        finally:
            process.send_signal(signal.SIGCONT)
        if which == "hub":
            await run.stopped(at)
            run.nothing_moves_after(at)
        else:
            # Frozen, it cannot say zero; the robot's own time-out is what stops it.
            run.nothing_moves_after(at + round(seconds * 1e9) - round(ledgers.STOP_MS * MS))
        async with back(findings):
            if seconds < FAREWELL_S:
                await sees_values(driver)
            else:
                # Whoever was silent for so long has been hung up on; a page dials again.
                async with page(world, "driver") as anew:
                    await sees_values(anew)


async def _freeze_database(
    world: World, seconds: float, chance: random.Random, findings: Findings
) -> None:
    """Nothing that moves the robot waits for a database that stands still."""
    async with (
        postgres(world) as server,
        under_load(world, findings) as run,
        page(world, "driver") as driver,
    ):
        await run.press(driver)
        await run.mark(driver)
        await pause(chance)
        at = now()
        with server.frozen():
            await lasts_for(min(seconds, UNSURE_S) / 2)
            # Who may do what was known a moment ago: nothing that moves the robot waits.
            moving = now()
            await until(lambda: any(x.moves for x in world.told(moving)), 2, "driving meanwhile")
            if seconds <= UNSURE_S:
                moving = now()
                await run.let_go()
                await run.stopped(moving)
            else:
                # Nobody knows any more whether the driver still may; the finger is on the key.
                await lasts_for(seconds - UNSURE_S / 2)
                run.nothing_moves_after(at + round((UNSURE_S + CHECKED_S) * 1e9))
                await run.let_go()
        async with back(findings):
            await sees_values(driver)


async def f7(world: World, chance: random.Random, findings: Findings) -> None:
    """The gateway's disk is full: old samples give way, driving and STOP do not."""
    with small_disk(world.folder / f"small-{now()}", "8m") as disk:
        world.gateway.end()
        if world.hub.popen.poll() is not None:  # the row before had a hub of its own
            world.start_hub()
        world.gateway_data = disk / "gateway"
        try:
            world.start_gateway()
            await world.ready()
            async with under_load(world, findings) as run:
                with (disk / "filler").open("wb", buffering=0) as filler, \
                        contextlib.suppress(OSError):  # fmt: skip
                    while filler.write(bytes(4096)):
                        pass
                async with page(world, "driver") as driver:
                    await run.press(driver)
                    await run.mark(driver)
                    at = now()
                    name = f"full-{at}"
                    await driver.say(browser.PageStop(site=SITE, device="base", id=name))
                    await driver.sees(browser.StopUpdate, lambda x: x.id == name and x.latched)
                    await run.stopped(at)
                    await run.let_go()
                    # On a full disk it comes up again, and still stopped.
                    knew = world.said()[-1].known
                    world.gateway.kill()
                    since = len(driver.got)
                    world.start_gateway()
                    await world.ready()
                    await driver.sees(browser.StopUpdate, lambda x: x.latched, since=since)
                    await until(lambda: world.said()[-1].known > knew, 30, "the new gateway")
                    world.proxy.cut()
                    await run.turn_door()
                    await pause(chance)
                    (disk / "filler").unlink()
                    async with back(findings):
                        await sees_values(driver)
                    await reset(driver)
        finally:
            world.gateway.end()
            world.gateway_data = world.folder / "gateway"


async def f3(world: World, chance: random.Random, findings: Findings) -> None:
    """`kill -9` the database server; the hub holds what comes, and the gateway what it must."""
    async with (
        postgres(world) as server,
        under_load(world, findings) as run,
        page(world, "driver") as driver,
    ):
        await run.press(driver)
        await pause(chance)
        server.kill()
        await lasts_for(0.5)
        # Nothing that moves the robot waits for a database.
        at = now()
        await until(lambda: any(x.moves for x in world.told(at)), 2, "driving without a database")
        at = now()
        await run.let_go()
        await run.stopped(at)
        await run.turn_door()
        server.start()
        async with back(findings):
            await until(lambda: "stored again" in world.hub.said(), 30, "storing again")


async def f8(world: World, chance: random.Random, findings: Findings) -> None:
    """The hub's disk is full: nothing is acknowledged, the gateway keeps it, driving goes on."""
    world.gateway.end()
    world.hub.end()
    with small_disk(world.folder / f"hub-{now()}", "48m") as disk:
        for name in ("talaia.db", "talaia.db-wal", "talaia.db-shm"):
            if (world.hub_data / name).exists():
                shutil.copy(world.hub_data / name, disk / name)
        kept, world.hub_data = world.hub_data, disk
        try:
            async with under_load(world, findings) as run, page(world, "driver") as driver:
                filler = disk / "filler"
                with filler.open("wb", buffering=0) as file, contextlib.suppress(OSError):
                    while file.write(bytes(4096)):
                        pass
                await run.press(driver)
                await until(lambda: "cannot be stored" in world.hub.said(), 20, "a full disk")
                await pause(chance)
                at = now()
                await run.let_go()
                await run.stopped(at)
                await run.turn_door()
                filler.unlink()
                async with back(findings):
                    await until(lambda: "stored again" in world.hub.said(), 30, "room again")
        finally:
            world.hub.end()
            world.hub_data = kept
            world.start_hub()


async def f11(world: World, chance: random.Random, findings: Findings) -> None:
    """The wall clock jumps on one side: by an hour, to 1970, by ten years."""
    which = chance.choice(("hub", "gateway"))
    year = 365 * 86400.0
    offset = chance.choice((3600.0, -3600.0, -time.time(), 10 * year))
    findings.counted[f"{which} {offset:+.0f} s"] += 1
    world.offset_s[which] = offset
    try:
        (world.hub if which == "hub" else world.gateway).end()
        world.gateway.end()
        if which == "hub":
            world.start_hub()
            await world.hub.says("ready")
        started = now()
        world.start_gateway()
        async with under_load(world, findings) as run, page(world, "driver") as driver:
            await run.press(driver)
            await lasts_for(max(0.0, 3.0 - (now() - started) / 1e9))
            await run.mark(driver)
            at = now()
            await until(lambda: any(each.moves for each in world.told(at)), 2, "driving goes on")
            at = now()
            await run.let_go()
            await run.stopped(at)
    finally:
        world.offset_s[which] = 0.0
        world.hub.end()
        world.gateway.end()
        world.start_hub()


async def f12(world: World, chance: random.Random, findings: Findings) -> None:
    """Partition of 5 s, 5 min, 24 h (the long ones as what a gateway then has on its disk)."""
    lasting = ("5 s", "5 min", "24 h")[findings.turn % 3] if world.long else "short"
    findings.counted[lasting] += 1
    if lasting == "24 h":
        await long_partition(world, findings, 86_400, 10)
    elif lasting == "5 min":
        await long_partition(world, findings, 300, 200)
    else:
        await _dark(world, chance, findings, 5.0 if world.long else chance.uniform(1.0, 2.0))


async def _dark(world: World, chance: random.Random, findings: Findings, seconds: float) -> None:
    """Nothing passes for a while, then all that waited comes late."""
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        await pause(chance)
        at = now()
        world.proxy.change(Weather(dark=frozenset(Way)))
        await run.mark(driver)
        await run.turn_door()
        await run.stopped(at)
        await lasts_for(max(0.0, seconds - (now() - at) / 1e9))
        await run.let_go()
        world.proxy.change(Weather())
        async with back(findings):
            await sees_values(driver)
        run.nothing_moves_after(at)


async def f13(world: World, chance: random.Random, findings: Findings) -> None:
    """One way is dark, without a reset: both sides find out within three beats."""
    dark = chance.choice(([Way.UP], [Way.DOWN], [*Way]))
    findings.counted["dark " + " and ".join(dark)] += 1
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        since, said = len(driver.got), len(world.gateway.said())
        at = now()
        world.proxy.change(Weather(dark=frozenset(dark)))
        if Way.DOWN in dark:
            await run.stopped(at)
        limit = BEATS_S + BEATS_LATE_S
        for side, found in (
            ("hub", driver.sees(browser.SiteUpdate, lambda x: not x.online, since=since, within=8)),
            ("gateway", until(lambda: "trying again" in world.gateway.said()[said:], 8, "a loss")),
        ):
            await found
            took = (now() - at) / 1e9
            findings.counted[f"{side} found, ms"] += round(took * 1000)
            if took > limit:
                findings.breach("I6", f"the {side} found out only after {took:.1f} s")
        await run.stopped(at, within=5)
        await run.turn_door()
        await run.let_go()
        world.proxy.change(Weather())
        async with back(findings):
            await driver.sees(
                browser.SiteUpdate, lambda x: x.online, since=len(driver.got), within=ledgers.BACK_S
            )
            await sees_values(driver)


async def f14(world: World, chance: random.Random, findings: Findings) -> None:
    """Latency with jitter, from a good line to one over a satellite that nobody can drive by."""
    ms = chance.choice((20.0, 150.0, 300.0, 1000.0))
    findings.counted[f"{ms:g} ms"] += 1
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        began = now()
        world.proxy.change(
            Weather(delay_ms=ms / 2, jitter_ms=ms / 4, split=0.2, rate=chance.choice((0, 2e5)))
        )
        await run.mark(driver)
        await lasts_for(1.0)
        at = now()
        await run.let_go()
        await run.stopped(at)
        findings.figures["oldest motion, ms"].append(max(run.ages_since(began), default=0.0))
        world.proxy.change(Weather())
        async with back(findings):
            await sees_values(driver)


async def f19(world: World, chance: random.Random, findings: Findings) -> None:
    """The link is cut again and again; half-closed now and then."""
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        at = now()
        for _ in range(10 if world.long else 5):
            if chance.random() < 0.3:
                world.proxy.half_close(chance.choice([*Way]))
            else:
                world.proxy.cut()
            await asyncio.sleep(0.2)
        await run.turn_door()
        async with back(findings, ledgers.ALONE_S):
            await sees_values(driver)
        await run.stopped(at)
        run.nothing_moves_after(at)


async def f20(world: World, chance: random.Random, findings: Findings) -> None:
    """Two gateways with one key: the one that was there first stays, and people are told."""
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        run.one_gateway = False
        first, data = world.gateway, world.gateway_data
        since = len(driver.got)
        world.gateway_data = world.folder / f"twin-{now()}"
        log = world.folder / f"twin-{now()}.log"
        with contextlib.ExitStack() as stack:
            twin = Process(_twin_words(world), log, world._ros)
            stack.callback(twin.end)
            world.gateway_data = data
            await twin.says("lets this gateway wait")
            event = await driver.sees(
                browser.EventUpdate, lambda x: x.kind == "second gateway", since=since
            )
            assert not event.good
            for _ in range(3 if world.long else 1):
                # Whoever dials first, the one that was there before is linked in the end.
                await pause(chance)
                before = first.said().count("linked to")
                world.proxy.cut()
                await first.says("linked to", within=ledgers.BACK_S, times=before + 1)
                await asyncio.sleep(1.5)
                if first.said().count("lets this gateway wait"):
                    findings.breach("F20", "the gateway that was there first had to wait")
        assert first.popen.poll() is None
        async with back(findings):
            await driver.sees(
                browser.SiteUpdate, lambda x: x.online, since=len(driver.got), within=60
            )
            await sees_values(driver)


def _twin_words(world: World) -> list[str]:
    return [
        "-m", "talaia", "gateway", str(world.folder / "site.yaml"), "--allow-plain",
        "--hub", f"ws://127.0.0.1:{world.proxy.port}", "--key-file", str(world.folder / "key"),
        "--data", str(world.gateway_data), "--ros-domain", str(world._world.domain),
    ]  # fmt: skip


async def f21(world: World, chance: random.Random, findings: Findings) -> None:
    """Malformed frames to every door of the hub: it closes with a code and goes on."""
    key = (world.folder / "key").read_text()
    cookie = await sign_in(world, "second")
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        before = world.memory()["hub"]
        good = [
            browser.FROM_BROWSER.encode(browser.PagePing(n=1, at_ms=0.0)),
            frames.LINK_FROM_GATEWAY.encode(frames.Beat(n=1, mono_us=1)),
        ]
        for _ in range(100 if world.long else 25):
            await _throw(world, _mutilated(chance, good), key, cookie, chance)
            findings.counted["malformed"] += 1
        grown = world.memory()["hub"] - before
        if grown > 32:
            findings.breach("I7", f"the hub grew by {grown:.0f} MiB over malformed frames")
        at = now()
        await run.let_go()
        await run.stopped(at)


def _mutilated(chance: random.Random, good: list[bytes]) -> bytes | str:
    """Give bytes that are nearly a message, far from it, deep, or large."""
    data = bytearray(chance.choice(good))
    match chance.randrange(6):
        case 0:
            return bytes(data[: chance.randrange(len(data))])
        case 1:
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
            return bytes(data)
        case 2:
            return b"\x91" * chance.randrange(1, 100_000)
        case 3:
            return bytes(chance.randrange(256) for _ in range(chance.randrange(400)))
        case 4:
            return '{"t":"ping","n":1e999,"at_ms":NaN}' + "[" * chance.randrange(10_000)
        case _:
            return b"\xdf\xff\xff\xff\xff" + bytes(data)


async def _throw(
    world: World, data: bytes | str, key: str, cookie: str, chance: random.Random
) -> None:
    """Send it where it hurts most; the door closes by itself or stays, and both are fine."""
    if chance.random() < 0.5:
        dialled = connection(world, cookie)
    else:
        from websockets.asyncio.client import connect

        dialled = connect(
            f"ws://localhost:{world.port}/gateway/{chance.choice(('link', 'media'))}",
            compression=None, proxy=None, close_timeout=1,
            additional_headers={"Authorization": f"Bearer {key}"},
        )  # fmt: skip
    with contextlib.suppress(websockets.ConnectionClosed, OSError, TimeoutError):
        async with dialled as socket:
            await socket.send(data)
            async with asyncio.timeout(0.05):
                while True:
                    await socket.recv()


async def f22(world: World, chance: random.Random, findings: Findings) -> None:
    """Whole frames come twice and change places, both ways, while somebody drives."""
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        await run.press(driver)
        world.proxy.change(Weather(duplicate=0.3, reorder=0.2, split=0.1, jitter_ms=20))
        for _ in range(5):
            await run.mark(driver)
            await asyncio.sleep(0.3)
        at = now()
        await run.let_go()
        await run.stopped(at)
        twice, turned, cut = world.proxy.dealt()
        findings.counted.update(repeated=twice, reordered=turned, split=cut)
        assert twice, "no frame was repeated"
        assert turned, "no frame changed places"
        world.proxy.change(Weather())
        async with back(findings):
            await sees_values(driver)


async def f23(world: World, chance: random.Random, findings: Findings) -> None:
    """Races for one lease: exactly one wins, and the loser is told who holds it."""
    async with (
        under_load(world, findings),
        page(world, "driver") as first,
        page(world, "second") as second,
    ):
        both = [first, second]
        for _ in range(100 if world.long else 20):
            chance.shuffle(both)
            got = await asyncio.gather(*(_ask(each) for each in both))
            findings.counted["races"] += 1
            if sum(each.yours for each in got) != 1:
                findings.breach("F23", f"{sum(each.yours for each in got)} hold the lease")
            for each in got:
                if not each.yours and not (each.holder and each.refused):
                    findings.breach("I6", "the loser is not told who holds it")
            winner = both[0] if got[0].yours else both[1]
            await winner.free()
        async with page(world, "second") as third:
            for _ in range(20 if world.long else 3):
                await _take_over([first, second, third], chance, findings)


async def _take_over(three: list[Page], chance: random.Random, findings: Findings) -> None:
    """Two ask the holder at once, who hands over: one of them gets it, the other is told."""
    chance.shuffle(three)
    holder, *askers = three
    assert (await holder.take()).yours
    since = [len(each.got) for each in three]
    await asyncio.gather(*(_lease(each, "ask") for each in askers))
    await holder.sees(browser.LeaseUpdate, lambda x: x.rival, since=since[0])
    await asyncio.gather(_lease(holder, "accept"), _lease(chance.choice(askers), "ask"))

    def got(each: Page) -> list[browser.LeaseUpdate]:
        news = each.got[since[three.index(each)] :]
        return [x for x in news if isinstance(x, browser.LeaseUpdate) and x.device == "base"]

    def having() -> list[Page]:
        return [each for each in three if got(each) and got(each)[-1].yours]

    # News travels: for a moment two may think so, but only one of them is right.
    await until(
        lambda: len(having()) == 1 and having()[0] is not holder, 8, "one holder, and a new one"
    )
    await lasts_for(0.1)
    findings.counted["take-overs"] += 1
    if len(having()) != 1:
        findings.breach("F23", f"{len(having())} hold the lease after a take-over")
    if not all(any(x.refused or x.asking or x.yours for x in got(each)) for each in askers):
        findings.breach("I6", "an asker was not answered")
    # Whoever still asks gets it from the one who frees it, and has to free it too.
    while any(got(each)[-1].holder for each in three):
        for each in three:
            await _lease(each, "free")
        await asyncio.sleep(0.1)


async def _lease(by: Page, op: str) -> None:
    await by.say(browser.PageLease(site=SITE, device="base", op=op))  # type: ignore[arg-type]


async def _ask(by: Page) -> browser.LeaseUpdate:
    since = len(by.got)
    await by.say(browser.PageLease(site=SITE, device="base", op="take"))  # type: ignore[arg-type]
    return await by.sees(
        browser.LeaseUpdate, lambda x: x.device == "base" and (x.yours or x.refused), since=since
    )  # type: ignore[return-value]


async def f24(world: World, chance: random.Random, findings: Findings) -> None:
    """The driver's session ends while the key is held down."""
    async with under_load(world, findings) as run:
        cookie = await sign_in(world, "driver")
        async with page(world, "driver", cookie=cookie) as driver:
            await run.press(driver)
            await pause(chance)
            async with httpx.AsyncClient(base_url=world.address, verify=usual_trust()) as client:
                headers = {"Origin": world.address, "Cookie": cookie}
                at = now()
                answer = await client.post("/api/logout", headers=headers)
                answer.raise_for_status()
            await run.stopped(at)
        await run.let_go()
        run.nothing_moves_after(at)


class Row(NamedTuple):
    """One line of the table; in a long run it gets time by its weight, and ``least`` runs."""

    name: str
    what: str
    run: Callable[[World, random.Random, Findings], Awaitable[None]]
    least: int = 1
    weight: float = 1.0


LEAST = {"F1": 20, "F2": 20, "F3": 10, "F4": len(POINTS), "F5": len(FREEZES), "F12": 3, "F10": 4}
WEIGHT = {"F4": 3.0, "F12": 2.0, "F10": 1.5, "F18": 1.0, "F23": 0.5, "F30": 0.7, "F24": 0.7}
ROWS = [
    Row(
        each.__name__.upper(), (each.__doc__ or "").rstrip(".").replace("\n", " "), each,
        LEAST.get(each.__name__.upper(), 1), WEIGHT.get(each.__name__.upper(), 1.0),
    )
    for each in (
        f1, f2, f3, f4, f5, f7, f8, f10, f11, f12, f13, f14, f16, f17, f18, f19, f20, f21, f22,
        f23, f24, f25, f30,
    )
]  # fmt: skip

__all__ = ["ROWS", "Row", "Run"]
