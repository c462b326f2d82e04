"""Rows of what is kept: a database, a backlog, a robot's answer, a description."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import random
import secrets
import shutil
import signal
import time
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import msgspec
import numpy as np
from async_program import start_program
from patience import lasts_for
from shared_trust import usual_trust
from websockets.asyncio.client import connect

from talaia.gateway.reload.current_description import catalogue_of
from talaia.gateway.spool.journal import SegmentHead, Spool
from talaia.gateway.spool.segment import SampleRecord
from talaia.hub import accounts
from talaia.model.yaml_text.load import load_site
from talaia.wire import browser, frames
from talaia.wire.columns import Columns, pack_columns

from ..people import Page, page
from ..stack import SOURCE, Process, until
from . import ledgers
from .crowd import hello
from .doing import ages, back, p99, pause, sees_values
from .ledgers import MS, Findings
from .rows_crowd import hub_settings
from .weather import Way, Weather
from .world import SITE, Run, World, now, under_load

STALE_S = 2.0
OLD_CHANNEL = "base/wheel1"
# The gateway's rate for old samples, and what lies round them on the wire.
BACKFILL_BYTES = 512 * 1024
OVERHEAD = 1.25


# ── F10 ──


def _overwrite(database: Path, chance: random.Random) -> None:
    size = database.stat().st_size
    with database.open("r+b") as file:
        for _ in range(20):
            file.seek(chance.randrange(size // 4096) * 4096)
            file.write(chance.randbytes(4096))


DAMAGE = {
    "head": lambda path, chance: path.write_bytes(chance.randbytes(4096)),
    "pages": _overwrite,
    "cut short": lambda path, _: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "missing": lambda path, _: path.unlink(),
}


async def f10(world: World, chance: random.Random, findings: Findings) -> None:
    """The hub's database is damaged or gone: set aside, restored; no recording is deleted."""
    how = chance.choice(sorted(DAMAGE))
    findings.counted[how] += 1
    world.gateway.end()
    world.hub.end()
    folder = world.folder / f"hub-{now()}"
    folder.mkdir(mode=0o700)
    for each in world.hub_data.glob("talaia.db*"):
        shutil.copy(each, folder / each.name)
    kept, world.hub_data = world.hub_data, folder
    try:
        async with under_load(world, findings) as run:
            recording = folder / "recordings" / "night.mcap"
            recording.parent.mkdir()
            recording.write_bytes(chance.randbytes(100_000))
            print_of = hashlib.sha256(recording.read_bytes()).hexdigest()
            copy = world.folder / f"backup-{now()}"
            await _talaia("backup", str(copy), "--data", str(folder))
            await pause(chance)
            # While a new, empty hub is there, this gateway does not reach it.
            world.proxy.change(Weather(dark=frozenset(Way)))
            world.hub.kill()
            world.proxy.cut()
            await run.turn_door()
            for end in ("-wal", "-shm"):
                (folder / f"talaia.db{end}").unlink(missing_ok=True)
            DAMAGE[how](folder / "talaia.db", chance)
            damaged = (folder / "talaia.db").exists()
            world.start_hub()
            await world.hub.says("ready")
            if damaged and not [*folder.glob("talaia.db.damaged-*")]:
                findings.breach("F10", f"a database with {how} damaged was not set aside")
            if hashlib.sha256(recording.read_bytes()).hexdigest() != print_of:
                findings.breach("F10", "a recording was touched")
            await _talaia("restore", str(copy), "--data", str(folder))
            world.hub.end()
            links = world.links
            world._cookie = ""
            world.start_hub()
            await world.hub.says("ready")
            world.proxy.change(Weather())
            async with back(findings):
                await world.linked_again(links)
                async with page(world, "second") as second:
                    await sees_values(second)
            found = [*folder.rglob("night.mcap")]
            if not found or any(
                hashlib.sha256(each.read_bytes()).hexdigest() != print_of for each in found
            ):
                findings.breach("F10", "a recording is gone")
    finally:
        world.hub.end()
        world.gateway.end()
        world.hub_data, world._cookie = kept, ""
        world.start_hub()


async def _talaia(*words: str) -> None:
    done = await start_program("-m", "talaia", *words, PYTHONPATH=str(SOURCE), with_errors=True)
    _, errors = await done.communicate()
    assert done.returncode == 0, errors.decode()


def _environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(SOURCE)}


# ── F12, the long ones ──


def fill_spool(world: World, seconds: int, rate: int) -> tuple[int, int]:
    """Leave a backlog in the gateway's folder, as a gateway does that was cut off for so long.

    Gives its times (µs, from and to).
    """
    described = load_site(world.description)
    channels = [each.address for each in described.channels()]
    boot = f"{time.time_ns() // 1_000_000 - seconds * 1000:012x}-{secrets.token_hex(4)}"
    head = SegmentHead(boot, catalogue_of(described), channels)
    spool = Spool(folder=world.gateway_data / "spool", head=head, bound=1 << 30)
    count, at_once = seconds * rate, 500
    from_us = time.time_ns() // 1000 - (seconds + 60) * 1_000_000
    for first in range(0, count, at_once):
        index = np.arange(first, min(first + at_once, count))
        times = from_us + index * (1_000_000 // rate)
        columns = Columns(
            np.full(index.size, channels.index(OLD_CHANNEL), np.uint16), times,
            np.sin(index / 100), {},
        )  # fmt: skip
        body = frames.LINK_FROM_GATEWAY.encode(frames.SampleBatch(
            boot=boot, first=first, catalogue=head.catalogue, **pack_columns(columns)._asdict(),
        ))  # fmt: skip
        spool.append_record(
            SampleRecord(first, int(index.size), int(times[0]), int(times[-1]), body)
        )
    spool.close()
    return from_us, from_us + seconds * 1_000_000


async def long_partition(world: World, findings: Findings, seconds: int, rate: int) -> None:
    """What waited for minutes or for a day comes behind the live samples, at a bounded rate."""
    world.gateway.end()
    if world.hub.popen.poll() is not None:
        world.start_hub()
    await world.hub.says("ready")
    # What earlier rows left is not to be counted.
    from_us, to_us = await asyncio.to_thread(fill_spool, world, seconds, rate)
    wanted = seconds * rate
    had = await _count(world, from_us, to_us)
    began = time.monotonic()
    async with (
        _rate(world, findings),
        under_load(world, findings) as run,
        page(world, "driver") as driver,
        ages(world) as looking,
    ):
        findings.figures["live stored after, s"].append(time.monotonic() - began)
        await run.press(driver)
        findings.figures["live p99 beside old, ms"].append(p99(await looking.during(1.5)))
        at = now()
        await run.let_go()
        await run.stopped(at)
        deadline = time.monotonic() + ledgers.BACK_S + wanted * 20 / BACKFILL_BYTES
        while (stored := await _count(world, from_us, to_us) - had) < wanted:
            if time.monotonic() > deadline:
                break
            await asyncio.sleep(0.3)
        findings.figures["all old stored after, s"].append(time.monotonic() - began)
        findings.counted["old samples"] += stored
        if stored < wanted:
            findings.breach("I1", f"{wanted - stored} of {wanted} old samples are not stored")
        if stored > wanted:
            findings.breach("I2", f"{stored - wanted} old samples are stored twice")


@contextlib.asynccontextmanager
async def _rate(world: World, findings: Findings) -> AsyncIterator[None]:
    """Watch how much the gateway sends: no second has more than its rate and what is live."""
    seconds: list[float] = []

    async def watch() -> None:
        while True:
            passed, since = world.proxy.passed[Way.UP], time.monotonic()
            await asyncio.sleep(1.0)
            seconds.append((world.proxy.passed[Way.UP] - passed) / (time.monotonic() - since))

    watching = asyncio.create_task(watch())
    try:
        yield
    finally:
        watching.cancel()
        await asyncio.gather(watching, return_exceptions=True)
    most = max(seconds, default=0.0)
    findings.figures["old and live at most, KiB/s"].append(most / 1024)
    if most > BACKFILL_BYTES * OVERHEAD:
        findings.breach("F12", f"old samples came at {most / 1024:.0f} KiB/s")


async def _count(world: World, from_us: int, to_us: int) -> int:
    query: dict[str, str | int] = {"channel": OLD_CHANNEL, "from_us": from_us, "to_us": to_us}
    async with httpx.AsyncClient(
        base_url=world.address, headers={"Cookie": await world.cookie()}, verify=usual_trust()
    ) as client:
        answer = await client.get(f"/api/sites/{SITE}/statistics", params=query)
    if answer.status_code == httpx.codes.NOT_FOUND:
        # A hub that has never heard of the site has nothing of it either.
        return 0
    answer.raise_for_status()
    return int(answer.json()["statistics"][0]["count"])


# ── F25 ──


async def f25(world: World, chance: random.Random, findings: Findings) -> None:
    """The robot hangs, or its service never answers: unknown within 2 s; the gateway stays."""
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        if world.long:
            await _hanging_service(world, driver, findings)
        await _frozen_robot(world, run, driver, chance, findings)


async def _ask(driver: Page, command: str) -> str:
    name = f"{command}-{now()}"
    await driver.say(browser.PageCommand(site=SITE, device="base", command=command, id=name))
    return name


async def _ends_unknown(driver: Page, name: str, at: int, findings: Findings) -> None:
    final = await driver.sees(
        browser.CommandUpdate,
        lambda x: x.id == name and x.phase not in {"accepted", "running"}, within=5,
    )  # fmt: skip
    took = (now() - at) / MS
    findings.figures["unknown after, ms"].append(took)
    if final.phase != "unknown":
        findings.breach("F25", f"a command that was never answered ended as {final.phase}")
    if took > STALE_S * 1000:
        findings.breach("I6", f"unknown only after {took:.0f} ms")


async def _hanging_service(world: World, driver: Page, findings: Findings) -> None:
    world.robot.tell("hang")
    at = now()
    await _ends_unknown(driver, await _ask(driver, "work"), at, findings)
    # Beside a service that hangs, all else goes on.
    await sees_values(driver)
    world.robot.tell("answer")
    await until(lambda: world.heard("/work", at), 10, "the service answers at last")


async def _frozen_robot(
    world: World, run: Run, driver: Page, chance: random.Random, findings: Findings
) -> None:
    await run.press(driver)
    gateway, links = world.gateway.popen.pid, world.links
    at = now()
    world.robot.popen.send_signal(signal.SIGSTOP)
    try:
        name = await _ask(driver, "work")
        await _ends_unknown(driver, name, at, findings)
        await run.let_go()
        stop = f"hung-{at}"
        since = len(driver.got)
        await driver.say(browser.PageStop(site=SITE, device="base", id=stop))
        news = await driver.sees(browser.StopUpdate, lambda x: x.id == stop, since=since)
        await lasts_for(max(0.0, STALE_S - (now() - at) / 1e9))
        told = [x for x in driver.got[since:] if isinstance(x, browser.StopUpdate)]
        if not news.latched or any(each.confirmed for each in told):
            findings.breach("I6", "STOP looks confirmed by a robot that hangs")
        # Whoever opens the page now is told how old the last value is.
        await driver.say(browser.Subscribe(sub=3, site=SITE, channels=["base/open"], every_ms=0))
        last = await driver.sees(browser.Values, lambda x: x.sub == 3, since=since)
        age = min(last.age_ms, default=0.0)
        findings.figures["age shown, ms"].append(age)
        if age < (now() - at) / MS - 500:
            findings.breach("I6", f"the last value looks {age:.0f} ms old")
        await pause(chance, 0.0, 2.0 if world.long else 0.1)
    finally:
        world.robot.popen.send_signal(signal.SIGCONT)
    async with back(findings):
        await sees_values(driver)
    if world.gateway.popen.poll() is not None or world.gateway.popen.pid != gateway:
        findings.breach("I7", "the gateway did not stay up")
    if world.links != links:
        findings.breach("I7", "the link was lost over a robot that hung")
    asked = [each for each in world.heard("/work", at) if each.v == "done"]
    if len(asked) > 1:
        findings.breach("I3", f"the robot worked {len(asked)} times for one command")
    run.nothing_moves_after(now() - 1)
    await reset(driver)


async def reset(driver: Page) -> None:
    """Release STOP, and give the lease back."""
    assert (await driver.take()).yours
    about = {"site": SITE, "device": "base", "epoch": driver.epoch}
    since = len(driver.got)
    await driver.say(browser.PageReset(**about))  # type: ignore[arg-type]
    key = await driver.sees(browser.ResetTokenUpdate, since=since)
    assert key.token, key.refused
    await driver.say(browser.PageReset(**about, token=key.token))  # type: ignore[arg-type]
    await driver.sees(browser.StopUpdate, lambda x: not x.latched, since=since)
    await driver.free()


# ── F30 ──

BAD = {
    "no YAML": ("devices:\n", "devices: [\n", "line"),
    "unknown key": ("    kind: vehicle\n", "    kimd: vehicle\n", "devices.base"),
    "wrong type": ("max_speed: 0.5\n", "max_speed: fast\n", "max_speed"),
    "beyond a limit": ("max_speed: 0.5\n", "max_speed: -1\n", "max_speed"),
    "nobody's signal": ("[base/still]", "[base/nothing]", "base/nothing"),
}


async def f30(world: World, chance: random.Random, findings: Findings) -> None:
    """Bad descriptions are refused with the path to the mistake; the good one keeps running."""
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        names = sorted(BAD) if world.long else chance.sample(sorted(BAD), 1)
        since, gateway = len(driver.got), world.gateway.popen.pid
        for name in names:
            good, bad, path = BAD[name]
            text = world.description.replace(good, bad, 1)
            assert text != world.description, name
            await _refused_by_gateway(world, text, path, findings)
            said = await _hello(world, SITE, (world.folder / "key").read_text(), text)
            if not isinstance(said, frames.Bye) or path not in said.reason:
                findings.breach("F30", f"the hub answers {said} to {name}")
            findings.counted["refused"] += 1
        # Ten thousand signals are many, and no mistake: nobody else waits for them.
        signals = ", ".join(
            f"s{each}: {{name: S{each}, source: {{topic: /s, type: std_msgs/msg/Float64, "
            "field: data}}" for each in range(10_000)
        )  # fmt: skip
        key = await accounts.create_gateway(hub_settings(world), "many")
        before = world.memory()["hub"]
        async with ages(world) as looking:
            late = asyncio.create_task(looking.during(2.0 if world.long else 0.5))
            began = now()
            large = f"talaia: 1\nsite: many\nname: Many\nros2: {{}}\ndevices: {{hut: {{name: Hut, signals: {{{signals}}}}}}}\n"  # noqa: E501
            said = await _hello(world, "many", key, large)
            findings.figures["10 000 signals taken, ms"].append((now() - began) / MS)
            findings.figures["live p99 meanwhile, ms"].append(p99(await late))
        findings.figures["MiB for 10 000 signals"].append(world.memory()["hub"] - before)
        # They stay described, so their memory is no leak.
        run.leave_out("hub")
        if not isinstance(said, frames.Welcome):
            findings.breach("F30", f"10 000 signals: {said}")
        news = [x for x in driver.got[since:] if isinstance(x, browser.SiteUpdate)]
        if gone := [x for x in news if x.site == SITE and not x.online]:
            findings.breach("F30", f"the running site was disturbed: {gone[0].why}")
        assert world.gateway.popen.pid == gateway
        async with back(findings):
            await sees_values(driver)


async def _refused_by_gateway(world: World, text: str, path: str, findings: Findings) -> None:
    file = world.folder / "bad.yaml"
    file.write_text(text)
    words = ["-m", "talaia", "gateway", str(file), "--allow-plain", "--hub",
             f"ws://127.0.0.1:{world.port}", "--key-file", str(world.folder / "key"), "--data",
             str(world.folder / "bad-gateway")]  # fmt: skip
    trying = Process(words, world.folder / f"bad-{now()}.log", world._ros)
    try:
        await until(lambda: trying.popen.poll() is not None, 20, "the gateway's refusal")
    finally:
        trying.end()
    if trying.popen.returncode != 2 or path not in trying.said():
        findings.breach("F30", f"the gateway says {trying.said()[-300:]!r}, without {path!r}")


async def _hello(world: World, site: str, key: str, text: str) -> frames.FromHub | None:
    """Say hello with a description; give the hub's answer."""
    first = frames.LINK_FROM_GATEWAY.decode(hello(site))
    assert isinstance(first, frames.Hello)
    async with connect(
        f"ws://127.0.0.1:{world.port}/gateway/link", compression=None, proxy=None, close_timeout=1,
        additional_headers={"Authorization": f"Bearer {key}"},
    ) as link:  # fmt: skip
        await link.send(
            frames.LINK_FROM_GATEWAY.encode(msgspec.structs.replace(first, description=text))
        )
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(10):
                return frames.LINK_FROM_HUB.decode(await link.recv())
    return None


__all__ = ["f10", "f25", "f30", "long_partition", "reset"]
