"""One site with a network between gateway and hub, under load, and a judge over all of it."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import subprocess
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import httpx
import psutil
from patience import lasts_for
from shared_trust import usual_trust

from talaia.wire import browser

from ..people import Page, page, sign_in
from ..stack import DESCRIPTION, PASSWORD, PEOPLE, SITE, Process, Stack, until
from . import ledgers
from .ledgers import MS, Findings, Said, Told
from .looker import ALARM, COUNT, DOOR, LIMIT, Looker, differences
from .proxy import Proxy
from .weather import CALM

__all__ = ["PASSWORD", "PEOPLE", "SITE", "Run", "World", "now"]

# Values that the robot counts up (1/s): each costs robot, gateway, hub and judge.
RATE, SHORT_RATE = 200, 50
CRASHING = Path(__file__).parent / "crashing.py"
MARKS = """\
    commands:
      mark:
        name: Mark
        kind: topic
        target: /mark
        type: std_msgs/msg/Float64
        arguments: {value: {type: number, field: data, minimum: 0, maximum: 1000000000}}
      work:
        {name: Work, kind: service, target: /work, type: std_srvs/srv/Trigger, timeout: 1.5}
  stamped:
"""
SEEN = "      still: {name: Still,"
# Said only when it changes, and watched by an alarm.
CHANGES = """\
      door:
        name: Door
        max_age: 86400
        source: {topic: /door, type: std_msgs/msg/Float64, field: data}
"""
ALARMS = f"""\
alarms:
  {ALARM}:
    name: Door open
    kind: limit
    signal: {DOOR}
    above: {LIMIT:g}
    severity: critical
    max_age: 86400
"""


def now() -> int:
    """Give the moment on this machine's monotonic clock (ns)."""
    return time.monotonic_ns()


class World(Stack):
    """A `Stack` whose gateway reaches the hub through a `Proxy`."""

    description = (
        DESCRIPTION.replace("  stamped:\n", MARKS).replace(SEEN, CHANGES + SEEN, 1) + ALARMS
    )

    def __init__(self, folder: Path) -> None:
        """Start all of it in calm weather."""
        self.port = Stack._free_port(self)
        self.proxy = Proxy(self.port)
        self.crash = {"hub": "", "gateway": ""}
        self.offset_s = {"hub": 0.0, "gateway": 0.0}
        self.database_url = ""
        self.long = False
        self.more_words: list[str] = []
        self.gateway_data = folder / "gateway"
        self.hub_data = folder
        self._marks = 0
        self._cookie = ""
        super().__init__(folder, link_port=self.proxy.port)

    def _free_port(self) -> int:
        return self.port

    def _process(self, name: str, words: list[str], environment: dict[str, str]) -> Process:
        point = self.crash[name]
        if point:
            words = [str(CRASHING), *words[2:]]
            environment = {**environment, "TALAIA_CRASH_AT": point}
        elif self.offset_s[name]:
            words = [str(CRASHING), *words[2:]]
            environment = {**environment, "TALAIA_CLOCK_OFFSET_S": str(self.offset_s[name])}
        return Process(words, self.folder / f"{name}.log", environment)

    def start_hub(self) -> Process:
        words = ["-m", "talaia", "hub", "--data", str(self.hub_data), "--plain"]
        words += ["--host", "127.0.0.1", "--port", str(self.port)]
        more = {"TALAIA_DATABASE_URL": self.database_url} if self.database_url else {}
        self.hub = self._process("hub", words, more)
        return self.hub

    def start_gateway(self) -> Process:
        words = [
            "-m", "talaia", "gateway", str(self.folder / "site.yaml"), "--allow-plain",
            "--hub", f"ws://127.0.0.1:{self.proxy.port}", "--key-file", str(self.folder / "key"),
            "--data", str(self.gateway_data), "--ros-domain", str(self._world.domain),
            *self.more_words,
        ]  # fmt: skip
        self.gateway = self._process("gateway", words, self._ros)
        return self.gateway

    async def fresh(self) -> None:
        self.proxy.change(CALM)
        await super().fresh()
        self.proxy.forget()

    def told(self, since: int) -> list[Told]:
        """Give the velocities that reached the robot after a moment."""
        return [Told(t, float(v[0]), float(v[1])) for t, v in self.heard("/cmd_vel", since)]  # type: ignore[index]

    def said(self) -> list[Said]:
        return [Said(*line) for line in self.ledger()]

    def memory(self) -> dict[str, float]:
        """Give the resident memory of hub and gateway (MiB)."""
        parts = {"hub": self.hub, "gateway": self.gateway}
        return {
            name: psutil.Process(part.popen.pid).memory_info().rss / 2**20
            for name, part in parts.items()
            if part.popen.poll() is None
        }

    async def linked_again(self, links: int) -> None:
        await self.gateway.says("linked to", within=ledgers.BACK_S, times=links + 1)

    def next_door(self, *, is_open: bool) -> float:
        """Give a place of the door, told apart from all before, in this row and in others."""
        return round(10 * is_open + (time.time_ns() // MS % 10**7) / 1e7, 7)

    async def cookie(self) -> str:
        """Sign somebody in, once."""
        self._cookie = self._cookie or await sign_in(self, "second")
        return self._cookie

    @property
    def links(self) -> int:
        """How often this run of the gateway has been linked."""
        return self.gateway.said().count("linked to")

    def close(self) -> None:
        super().close()
        self.proxy.close()


class Run:
    """One run of a row: the robot counts, somebody drives, and everything is judged at the end."""

    def __init__(self, world: World, findings: Findings) -> None:
        """See `under_load`."""
        self.world, self.findings = world, findings
        self.driver: Page | None = None
        self.pressed: dict[float, int] = {}
        # Two gateways may each take the same value: a sample's key holds the run that took it.
        self.one_gateway = True
        self.from_us = time.time_ns() // 1000
        self._door_heard = True
        self._offset_us = round(world.offset_s["gateway"] * 1e6)
        self._looker = Looker(world)
        # What the robot said last on the door, and whether a gateway was there to hear it.
        self._door: float | None = None
        self._door_turn = 0
        self._disordered: set[int] = set()
        self._began = self._driven_from = now()
        self._first = len(world.said())
        self._holding: asyncio.Task[None] | None = None
        self._asked: list[float] = []
        self._memory = world.memory()

    def not_ours_until(self, moment: int) -> None:
        """Leave out what was driven before a moment: a page drove that keeps no ledger."""
        self._driven_from = moment

    def memory_from_now(self) -> dict[str, float]:
        """Let the memory of now be the one to come back to; gives it (MiB)."""
        self._memory = self.world.memory()
        return self._memory

    def leave_out(self, process: str) -> None:
        """Ask nothing of a process's memory: it has been given more to keep."""
        self._memory.pop(process, None)

    def ages_since(self, moment: int) -> list[float]:
        """Give how old each motion was when the robot was told it (ms)."""
        told = [each for each in self.world.told(moment) if each.moves]
        return [
            (each.at - self.pressed[key]) / MS
            for each in told
            if (key := round(each.linear, 7)) in self.pressed
        ]

    async def begin_anew(self) -> None:
        """Judge what is said from a moment from now on."""
        await lasts_for(2 * ledgers.MATCHING_NS / 1e9)
        self._first = len(self.world.said())

    # ── driving ──

    async def press(self, driver: Page) -> None:
        """Take the lease and hold a direction; each frame asks for a speed of its own."""
        self.driver = driver
        assert (await driver.take()).yours, "no lease"
        began = now()
        self._holding = asyncio.create_task(self._hold(driver))
        await until(
            lambda: any(each.moves for each in self.world.told(began)), 10, "the robot told to move"
        )

    async def _hold(self, driver: Page) -> None:
        turn = 0
        with contextlib.suppress(ConnectionError, OSError, Exception):
            while True:
                speed = round(0.1 + len(self.pressed) * 1e-5, 7)
                self.pressed[speed] = now()
                await driver.frame(speed)
                turn += 1
                if turn % 20 == 0:
                    renew = browser.PageLease(site=SITE, device="base", op="renew")  # type: ignore[arg-type]
                    await driver.say(renew)
                await asyncio.sleep(0.05)

    async def let_go(self) -> None:
        """Take the finger off without a word."""
        if self._holding is not None:
            self._holding.cancel()
            await asyncio.gather(self._holding, return_exceptions=True)
            self._holding = None

    async def stopped(self, fault: int, within: float = 3.0) -> None:
        """I5: the robot is told zero after ``fault``, in time and for good."""

        def silent() -> bool:
            told = self.world.told(fault)
            last = max((each.at for each in told if each.moves), default=fault)
            return now() - last > 300 * MS and bool(told) and not told[-1].moves

        try:
            await until(silent, within, "a zero, and no motion behind it")
        except AssertionError as error:
            self.findings.breach("I5", str(error))
        ms = ledgers.stop_ms(self.world.told(fault), fault)
        self.findings.stops_ms.append(ms)
        stall = ledgers.stall_ms(self.world.said()[self._first :], fault + round(min(ms, 1e6) * MS))
        # What the robot heard while it did not run itself was told it before.
        if ms > ledgers.STOP_MS + (stall if stall > ledgers.STALL_MS else 0):
            what = f"told zero after {ms:.0f} ms (the robot stood {stall:.0f} ms)"
            self.findings.breach("I5", what)

    def nothing_moves_after(self, end: int) -> None:
        """I4: not even what still was on its way."""
        end += round(ledgers.STOP_MS) * MS
        for each in ledgers.moved_after(self.world.told(end), end):
            late = (each.at - end) / MS
            self.findings.breach("I4", f"moved {late:.0f} ms after all motion had to end")

    # ── what is said only when it changes ──

    async def turn_door(self, *, heard: bool = True) -> None:
        """Let the robot say once that the door has moved, across the alarm's limit.

        ``heard`` tells whether a gateway is there that hears it.
        """
        self._door_turn += 1
        self._door = self.world.next_door(is_open=self._door_turn % 2 == 1)
        self._door_heard = heard
        word = f"door is {self._door}"
        self.world.robot.tell(f"door {self._door}")
        await self.world.robot.says(word)

    async def agrees(self) -> None:
        """I8: page, alarm, last-value API and history agree, soon, on what was said last."""
        began, found = now(), ["nothing was looked at"]
        expected = {COUNT: float(self.world.said()[-1].value)}
        if self._door is not None and self._door_heard:
            expected[DOOR] = self._door
        looked, look_ns = began, 0
        while found and now() - began < ledgers.BACK_S * 1e9:
            looked = now()
            with contextlib.suppress(httpx.HTTPError):
                last, history = await self._last(), await self._history_last()
                looker = self._looker
                found = differences(looker.shown, looker.alarm, last, history, expected)
            look_ns = max(look_ns, now() - looked)
            await asyncio.sleep(0.05)
        # It was so when the look began that found it so; how long a look takes is the machine's.
        took = (looked - began) / 1e9
        self.findings.figures["agreed after, s"].append(took)
        self.findings.figures["a look took, s"].append(look_ns / 1e9)
        if found or took > ledgers.AGREE_S + look_ns / 1e9:
            self.findings.breach("I8", f"after {took:.1f} s: {'; '.join(found) or 'late'}")

    async def _last(self) -> dict[str, tuple[float, int]]:
        now_us = time.time_ns() // 1000 + self._offset_us
        # A gateway that starts begins with the right time: the door may be from before the jump.
        door = self._looker.shown.get(DOOR)
        ends = {COUNT: now_us, DOOR: max(now_us, door.time_us if door else 0)}
        values = []
        for address, end_us in ends.items():
            query = {"channel": [address], "before_us": max(end_us + 10_000_000, 1)}
            values += (await self._get("last", query))["values"]
        return {value["address"]: (value["v"], value["t_us"]) for value in values}

    async def _history_last(self) -> dict[str, tuple[float, int]]:
        # By the end of what the last-value API says: the gateway's clock may be anywhere.
        last = await self._last()
        found = {}
        for address, (_, time_us) in last.items():
            query = {
                "channel": [address], "from_us": time_us - 500_000, "to_us": time_us + 10_000_000,
                "width": 10_000,
            }  # fmt: skip
            (series,) = (await self._get("history", query))["series"]
            found[address] = (series["v"][-1], series["t_us"][-1])
        return found

    async def _get(self, what: str, query: dict[str, object]) -> dict[str, Any]:
        cookie = await self.world.cookie()
        async with httpx.AsyncClient(
            base_url=self.world.address,
            headers={"Cookie": cookie},
            timeout=ledgers.BACK_S,
            verify=usual_trust(),
        ) as client:
            answer = await client.get(f"/api/sites/{SITE}/{what}", params=query)
        if answer.status_code == httpx.codes.UNAUTHORIZED:
            # A hub whose clock jumped by years has ended every session, as it must.
            self.world._cookie = ""
            return await self._get(what, query)
        answer.raise_for_status()
        return answer.json()

    # ── commands ──

    async def mark(self, by: Page) -> None:
        """Ask for a command that the robot writes down; twice, as a nervous finger does."""
        self.world._marks += 1
        value = float(self.world._marks)
        self._asked.append(value)
        name = f"mark-{os.getpid()}-{self.world._marks}"
        ask = browser.PageCommand(
            site=SITE, device="base", command="mark", id=name, args={"value": value}
        )
        with contextlib.suppress(Exception):
            await by.say(ask)
            await by.say(ask)

    # ── judging ──

    async def judge(self) -> None:
        """Hold the ledgers against I1 to I4, once all is quiet."""
        await self.let_go()
        world, findings = self.world, self.findings
        quiet = world.robot.said().count("quiet")
        world.robot.tell("quiet")
        await world.robot.says("quiet", times=quiet + 1)
        await self.agrees()
        said = world.said()[self._first :]
        wall = {each.value: (each.at + time.time_ns() - now()) // 1000 for each in said}
        deadline = now() + round(ledgers.BACK_S * 1e9)
        while True:
            stored, gaps = await self.stored()
            missing = ledgers.lost(said, stored, gaps, wall)
            if not missing or now() > deadline:
                break
            await asyncio.sleep(0.2)
        if missing:
            edge = f"{min(missing)} to {max(missing)} of {said[0].value} to {said[-1].value}"
            times = wall[min(missing)], wall[max(missing)]
            spans = [[(at - times[0]) / 1e6 for at in gap] for gap in gaps]
            edge += f"; {(times[1] - times[0]) / 1e6:.1f} s; gaps from then on: {spans}"
            findings.breach("I9", f"{len(missing)} values lost, and no gap tells of them ({edge})")
        for value in ledgers.doubled(stored) if self.one_gateway else ():
            findings.breach("I2", f"{value} is stored twice")
        for value in sorted(self._disordered)[:5] if self.one_gateway else ():
            findings.breach("I10", f"{value} is stored out of order")
        marks = [float(each.v) for each in world.heard("/mark", self._began)]  # type: ignore[arg-type]
        for value in ledgers.repeated(marks):
            findings.breach("I3", f"command {value} acted more than once")
        for told, age in ledgers.stale(world.told(self._driven_from), self.pressed):
            stall = ledgers.stall_ms(said, told.at)
            if age > ledgers.TTL_MS + ledgers.HOP_MS + stall:
                what = f"a motion {age:.0f} ms old ({told.linear}; the robot stood {stall:.0f} ms)"
                findings.breach("I4", what)
        await self._memory_is_back()
        findings.counted.update(values=len(said), stored=len(stored), gaps=len(gaps))
        findings.counted.update(commands=len(self._asked), frames=len(self.pressed))

    async def _memory_is_back(self) -> None:
        """I7: hub and gateway need no more than before, soon after."""
        deadline = now() + round(ledgers.BACK_S * 1e9)
        while True:
            after = self.world.memory()
            ratios = {key: after[key] / mib for key, mib in self._memory.items() if key in after}
            if all(ratio <= ledgers.MEMORY for ratio in ratios.values()) or now() > deadline:
                break
            await asyncio.sleep(0.5)
        self.findings.memory += ratios.values()
        for name, ratio in ratios.items():
            if ratio > ledgers.MEMORY:
                mib = f"{self._memory[name]:.0f} to {after[name]:.0f} MiB"
                self.findings.breach("I7", f"the {name} keeps {ratio:.2f} of its memory ({mib})")

    async def stored(self) -> tuple[list[int], list[tuple[int, int]]]:
        """Give the values in the database since this run began, and its gaps (from, to; µs)."""
        values, gaps = await self._window(self.from_us, time.time_ns() // 1000)
        if self._offset_us:
            # The samples' times jump with the gateway's clock; their order does not.
            offset = self._offset_us
            from_us, to_us = self.from_us + offset, time.time_ns() // 1000 + offset
            more, more_gaps = await self._window(max(0, from_us), max(1_000_000, to_us))
            return [*values, *more], [*gaps, *more_gaps]
        return values, gaps

    async def _window(self, from_us: int, to_us: int) -> tuple[list[int], list[tuple[int, int]]]:
        query: dict[str, object] = {
            "channel": COUNT, "from_us": from_us, "to_us": to_us, "width": 10_000
        }  # fmt: skip
        (series,) = (await self._get("history", query))["series"]
        assert series["kind"] == "exact", series["kind"]
        gaps = [(gap["from_us"], gap["to_us"]) for gap in series["gaps"]]
        values = [int(value) for value in series["v"]]
        self._disordered |= ledgers.disordered(values)
        return values, gaps


@contextlib.asynccontextmanager
async def under_load(world: World, findings: Findings) -> AsyncIterator[Run]:
    """Let the robot count, give the run, and judge it when the row is through."""
    await world.fresh()
    run = Run(world, findings)
    world.robot.tell(f"count {RATE if world.long else SHORT_RATE}")
    # From the first value that is stored on, every one is asked for.
    deadline = now() + 20_000 * MS
    while not (await run.stored())[0]:
        assert now() < deadline, "nothing is stored"
        await asyncio.sleep(0.05)
    run._first = len(world.said())
    try:
        await run.turn_door()
        yield run
        await run.judge()
    finally:
        await run.let_go()
        await run._looker.end()
        world.proxy.change(CALM)
        if world.robot.popen.poll() is None:
            world.robot.tell("quiet")


@contextlib.contextmanager
def small_disk(folder: Path, size: str) -> Iterator[Path]:
    """Mount a file system of ``size`` in memory.

    Raises:
        PermissionError: this user may not mount.

    """
    folder.mkdir(parents=True, exist_ok=True)
    words = ["mount", "-t", "tmpfs", "-o", f"size={size},mode=700", "tmpfs", str(folder)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode:
        raise PermissionError(f"a small disk cannot be mounted here: {done.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=False)
        shutil.rmtree(folder, ignore_errors=True)


__all__ += ["page", "small_disk", "under_load"]
