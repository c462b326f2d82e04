"""Lines of a robot's log between the robot and the hub: over restarts, and in bounded room."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from patience import until_answered

from talaia.gateway.robot_log.line_files import LineFiles
from talaia.gateway.robot_log.line_queue import SEGMENT_BYTES, LineQueue
from talaia.gateway.robot_log.log_reporter import LogReporter
from talaia.wire.frames import LogLine, RobotLogAck, RobotLogBatch

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.wire.frames import FromGateway


def line(number: int, text: str = "") -> LogLine:
    return LogLine(time_us=number, level=30, node="lidar", text=text or f"line {number}")


async def comes(holds: Callable[[], object]) -> None:
    async def ask() -> object:
        return holds()

    await until_answered(ask)


class Run:
    """A run of a gateway, with what it sent."""

    def __init__(self, folder: Path, boot: str) -> None:  # noqa: D107
        self.sent: list[RobotLogBatch] = []
        self.reporter = LogReporter(
            boot=boot,
            files=LineFiles(folder),
            send=self._keep,
            on_disk=self._on_disk,
            loop=asyncio.get_running_loop(),
        )
        self.task = asyncio.create_task(self.reporter.run())

    def _keep(self, message: FromGateway) -> None:
        assert isinstance(message, RobotLogBatch)
        self.sent.append(message)

    async def _on_disk(self, work: Callable[[], None]) -> None:
        work()

    async def kill(self) -> None:
        """End it as a power cut does."""
        self.task.cancel()
        await asyncio.gather(self.task, return_exceptions=True)


async def test_what_a_killed_gateway_heard_is_told_by_the_next_one_under_its_own_numbers(
    tmp_path: Path,
) -> None:
    first = Run(tmp_path, "000000000001-a")
    for number in range(250):
        first.reporter.keep_line(line(number))
    await comes(lambda: [*tmp_path.iterdir()])
    await first.kill()
    (file,) = tmp_path.iterdir()  # noqa: ASYNC240
    # The last line was broken off.
    file.write_bytes(file.read_bytes() + b'\n{"number": 250, "si')
    second = Run(tmp_path, "000000000002-b")
    second.reporter.keep_line(line(1000))
    second.reporter.link_up(takes=True)
    told: dict[tuple[str, int], str] = {}
    while len(told) < 251:
        await comes(lambda: second.sent)
        (batch,) = second.sent
        second.sent.clear()
        for place, one in enumerate(batch.lines):
            told[batch.boot, batch.first + place] = one.text
        second.reporter.handle_ack(
            RobotLogAck(boot=batch.boot, below=batch.first + len(batch.lines))
        )
    expected = {("000000000001-a", number): f"line {number}" for number in range(250)}
    assert told == {**expected, ("000000000002-b", 0): "line 1000"}
    await comes(lambda: not [*tmp_path.iterdir()])
    await second.kill()


async def test_what_was_not_acknowledged_is_told_again_on_a_new_link_and_not_to_an_old_hub(
    tmp_path: Path,
) -> None:
    run = Run(tmp_path, "boot")
    run.reporter.keep_line(line(1))
    run.reporter.link_up(takes=True)
    await comes(lambda: run.sent)
    run.reporter.link_lost()
    run.reporter.link_up(takes=False)
    assert len(run.sent) == 1
    run.reporter.link_up(takes=True)
    assert run.sent == [run.sent[0]] * 2
    await run.kill()


@pytest.mark.pure
def test_the_oldest_go_for_want_of_room_and_are_counted() -> None:
    queue = LineQueue("boot", most_bytes=4 * SEGMENT_BYTES)
    for number in range(10_000):
        queue.add_line(line(number, "x" * 100))
    dropped, dropped_us = queue.collect_dropped()
    assert dropped + len(queue) == 10_000
    assert dropped > 5_000
    assert dropped_us == dropped - 1
    batch = queue.next_batch()
    assert batch[0].number == dropped
    assert queue.collect_dropped()[0] == 0
    # What stood for others stands for them all.
    queue = LineQueue("boot", most_bytes=SEGMENT_BYTES)
    queue.add_line(LogLine(time_us=1, level=30, left_out=500))
    while not queue.dropped:
        queue.add_line(line(2, "x" * 1000))
    assert queue.dropped >= 500 + SEGMENT_BYTES // 1200
