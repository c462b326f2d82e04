"""Lines of a robot's log while the database is away."""

from __future__ import annotations

import asyncio
import contextlib
from types import SimpleNamespace

from patience import until_answered

from talaia.clock import SystemClock
from talaia.hub.errors import StoreDown
from talaia.hub.live.robot_log_intake import RobotLogIntake
from talaia.wire.frames import LogLine, RobotLogAck, RobotLogBatch


class AwayStore:
    """A store whose database does not answer for some tries."""

    def __init__(self, tries: int) -> None:
        """Fail so many times."""
        self.left = tries
        self.kept: list[str] = []

    async def store_lines(self, _site, _boot, _first, lines) -> None:
        if self.left:
            self.left -= 1
            raise StoreDown("the database does not answer", "")
        self.kept += [line.text for line in lines]

    async def delete_old(self, _before_us, _most) -> int:
        return 0


async def test_a_loss_and_a_recovery_are_said_once_and_nothing_is_acknowledged_between(
    caplog,
) -> None:
    store, acks = AwayStore(3), []
    intake = RobotLogIntake(store, SystemClock(), days=1, most=10, retry_s=0.0)
    site = SimpleNamespace(name="agv", link=SimpleNamespace(send=acks.append))
    running = asyncio.ensure_future(intake.run())
    try:
        line = LogLine(time_us=1, level=30, node="pump", text="dry")
        intake.handle_batch(site, RobotLogBatch(boot="run", first=0, lines=[line]))

        async def is_acknowledged() -> bool:
            return bool(acks)

        await until_answered(is_acknowledged)
    finally:
        running.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await running
    assert (store.kept, acks) == (["dry"], [RobotLogAck(boot="run", below=1)])
    said = [record.getMessage() for record in caplog.records]
    assert said == [
        "lines of robots' logs wait: the database does not answer",
        "lines of robots' logs are kept again",
    ]
