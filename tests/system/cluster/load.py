"""One row of several hubs under load: who drives, what the crowd's ledgers say, who was told."""

from __future__ import annotations

import asyncio
import contextlib
import json
import re
import time
from collections import Counter
from collections.abc import AsyncIterator

import httpx
import websockets
from patience import until_answered

from ..faults import ledgers
from ..faults.ledgers import Findings
from ..faults.world import Run, under_load
from ..people import Page, page
from .cluster_world import ClusterWorld
from .crowd import ADDRESS

_LOSSES = (OSError, TimeoutError, httpx.HTTPError, websockets.WebSocketException)
# So long somebody waits for control and for the robot before they come again (s).
_TRY_S = 10.0


class Load:
    """One row under load: who drives, whom the crowd's ledgers accuse, which messages came."""

    def __init__(self, world: ClusterWorld, run: Run, findings: Findings) -> None:
        """See `cluster_load`."""
        self.world, self.run, self.findings = world, run, findings
        self._began = time.monotonic_ns()
        self._raised = 0.0
        self._told_before = len(self._count_told())

    def begin_fault(self) -> None:
        """Let the crowd measure how long it hears nothing from now on."""
        self.world.tell_onlookers("fault")

    async def raise_alarm(self) -> None:
        """Let the robot open its door, whoever hears it."""
        await self.run.turn_door()
        self._raised = self.run._door or 0.0

    async def must_stop(self, at: int) -> None:
        """I5, I4: the fault ended the way to the robot, so it stands soon, and stays so."""
        told = self.world.told(self._began)
        # On a busy machine frames come too late, and then it stands already.
        before = [word for word in told if word.at <= at][-1:]
        if any(word.moves for word in (*before, *(word for word in told if word.at > at))):
            await self.run.stopped(at)
        await self.run.let_go()
        self.run.nothing_moves_after(at)

    @contextlib.asynccontextmanager
    async def driving(self) -> AsyncIterator[Page]:
        """Drive as somebody does who comes again, and presses again, until the robot moves."""
        ends = time.monotonic() + 2 * ledgers.BACK_S
        async with contextlib.AsyncExitStack() as stack:
            while True:
                try:
                    async with contextlib.AsyncExitStack() as tried:
                        # On a busy machine a link may be lost between two of these.
                        async with asyncio.timeout(_TRY_S):
                            driver = await tried.enter_async_context(page(self.world, "driver"))
                            await self.run.press(driver)
                        stack.push_async_exit(tried.pop_all())
                    break
                except (*_LOSSES, AssertionError):
                    await self.run.let_go()
                    if time.monotonic() > ends:
                        raise
            yield driver

    async def drive_again(self) -> None:
        """Drive and stop: after the fault as before it."""
        await self.run.let_go()
        async with self.driving():
            at = time.monotonic_ns()
            await self.run.let_go()
            await self.run.stopped(at)

    async def judge(self) -> None:
        """Hold the crowd's ledgers, the messages and the audit log against what is promised."""
        world, findings = self.world, self.findings
        assert world.crowd is not None
        asked = world.crowd.said().count("report ")
        world.crowd.tell("report")
        await world.crowd.says("report ", times=asked + 1)
        said = json.loads(world.crowd.said().splitlines()[-1].removeprefix("report "))
        for site in said["unsettled"]:
            findings.breach("I7", f"samples of {site} are not acknowledged after a minute")
        if said["blind"]:
            findings.breach("I6", f"{said['blind']} pages never saw a value")
        findings.figures["a gateway heard nothing for, s"] += said["gateways_s"]
        findings.figures["a page saw nothing new for, s"] += said["pages_s"]
        findings.counted["of the crowd"] += sum(said["ledger"].values())
        for site, acked in said["ledger"].items():
            await self._judge_site(site, acked)
        for ms in ledgers.left_moving(world.told(self._began)):
            if ms > ledgers.STOP_MS + ledgers.STALL_MS:
                findings.breach("I5", f"the robot was left moving for {ms:.0f} ms")
        await self._judge_browser()
        await self._judge_messages()
        verified = await world.ask("/api/audit/verify", await world.admin())
        if not verified.get("ok"):
            findings.breach("audit", f"the log is not whole: {verified}")

    async def _judge_browser(self) -> None:
        """I6, I10: pages in a Chromium go on by themselves, and show nothing old as new."""
        browser, findings = self.world.browser, self.findings
        if browser is None:
            return
        asked = browser.said().count("report ")
        browser.tell("report")
        await browser.says("report ", times=asked + 1)
        said = json.loads(browser.said().splitlines()[-1].removeprefix("report "))
        if said["blind"]:
            findings.breach("I6", f"{said['blind']} pages in Chromium show nothing new")
        if said["went_back"]:
            findings.breach("I10", f"a page in Chromium showed what was old {said['went_back']}×")
        findings.figures["a page in Chromium showed nothing new for, s"] += said["pages_s"]

    async def _judge_site(self, site: str, acked: int) -> None:
        path, cookie = f"/api/sites/{site}/history", await self.world.cookie()
        query = {"channel": ADDRESS, "from_us": 0, "to_us": 2**53, "width": 10_000}
        (series,) = (await self.world.ask(path, cookie, **query))["series"]
        stored = [int(number) for number in series["v"]]
        if missing := {*range(acked)} - {*stored}:
            edge = f"{min(missing)} to {max(missing)}"
            self.findings.breach("I1", f"{site}: {len(missing)} acknowledged are lost ({edge})")
        for number in ledgers.doubled(stored):
            self.findings.breach("I2", f"{site}: {number} is stored twice")

    async def _judge_messages(self) -> None:
        """Each alarm is told once: the one of the fault for certain, none twice."""
        told = f"Door is {self._raised:.4g}, above"

        async def has_come() -> bool:
            return bool(self._count_told()[told])

        try:
            async with asyncio.timeout(ledgers.BACK_S):
                await until_answered(has_come)
        except TimeoutError:
            self.findings.breach("alarm", f"nobody was told: {told}")
        for line, times in self._count_told().items():
            if times > 1:
                self.findings.breach("alarm", f"told {times} times: {line}")
        self.findings.counted["alarms told"] += len(self._count_told()) - self._told_before

    def _count_told(self) -> Counter[str]:
        """Count the doors that messages tell of."""
        texts = "\n".join(mail.text for mail in self.world.mailbox.mails)
        return Counter(re.findall(r"Door is \S+ above", texts))


@contextlib.asynccontextmanager
async def cluster_load(world: ClusterWorld, findings: Findings) -> AsyncIterator[Load]:
    """Let robot and crowd send and somebody drive; judge all of it when the row is through."""
    async with under_load(world, findings) as run:
        # It was opened by the way; shut before the fault, and open again in the midst of it.
        await run.turn_door()
        load = Load(world, run, findings)
        yield load
        await run.let_go()
        await run.turn_door()
        await load.judge()
