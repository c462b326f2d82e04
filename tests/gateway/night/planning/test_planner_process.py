"""The planner's process answers; one that dies is begun anew, and one that plans has all of it."""

from __future__ import annotations

import asyncio
import io
import os
import signal
import subprocess
import sys
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import pytest
from night_observatory import EVENING, example_site, request
from patience import PATIENCE_S

from talaia.gateway.night.planning.planner_child import answer_all, read_frame, write_frame
from talaia.gateway.night.planning.planner_process import PlannerProcess
from talaia.gateway.night.planning.planner_question import (
    PlannerAnswer,
    PlannerQuestion,
    PlannerSetup,
)
from talaia.model.observing.plan import Instrument
from talaia.model.observing.requests import Proposal, RequestGroup

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


def setup(*groups: RequestGroup) -> PlannerSetup:
    place = example_site().place
    assert place is not None
    return PlannerSetup(
        latitude=place.latitude,
        longitude=place.longitude,
        elevation=place.elevation,
        instrument=Instrument(),
        proposals=(Proposal(id="school", share=1.0, hours_allocated=10.0),),
        groups=groups,
    )


def question(number: int, **more: object) -> PlannerQuestion:
    return PlannerQuestion(number=number, time=EVENING, **more)


def answers(*asked: PlannerSetup | PlannerQuestion) -> list[PlannerAnswer]:
    """Give what the child's loop answers, in this process."""
    source, sink = io.BytesIO(), io.BytesIO()
    for one in asked:
        write_frame(source, msgspec.msgpack.encode(one))
    source.seek(0)
    answer_all(source, sink)
    sink.seek(0)
    found = []
    while (frame := read_frame(sink)) is not None:
        found.append(msgspec.msgpack.decode(frame, type=PlannerAnswer))
    return found


def test_what_is_done_or_held_is_not_chosen_again_and_nothing_is_chosen_of_nothing() -> None:
    first, second = request("a", priority=50.0), request("b")
    said = answers(
        question(1),
        setup(first, second),
        question(2),
        question(3, ended=("a",)),
        question(4, ended=("a",), held={"b": EVENING + 600.0}),
        setup(second),
        question(5, done={"b": (3,)}),
    )
    assert [one.number for one in said] == [1, 2, 3, 4, 5]
    assert [one.request for one in said] == ["", "a", "b", "", ""]
    assert said[1].plan is not None
    assert said[1].plan.night_start < EVENING < said[1].plan.night_end


@asynccontextmanager
async def planner() -> AsyncIterator[tuple[PlannerProcess, asyncio.Queue[PlannerAnswer]]]:
    told: asyncio.Queue[PlannerAnswer] = asyncio.Queue()
    process = PlannerProcess(told.put_nowait)
    task = asyncio.create_task(process.run())
    try:
        yield process, told
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def child_of_this_process() -> int:
    """Find the planner among this process's children."""
    for words in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            parent = int((words.parent / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == os.getpid() and b"planner_child" in words.read_bytes():
                return int(words.parent.name)
        except OSError:
            continue
    raise AssertionError("no planner runs")


@pytest.mark.parametrize("way", ["closed", "asked"])
def test_the_child_improves_while_nobody_asks_and_ends_with_its_gateway(way: str) -> None:
    many = [request(f"r{n}", hours_east=n % 9 - 2.0, frames=9, seconds=200.0) for n in range(80)]
    words = (sys.executable, "-m", "talaia.gateway.night.planning.planner_child")
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdin is not None
        assert child.stdout is not None
        write_frame(child.stdin, msgspec.msgpack.encode(setup(*many)))
        write_frame(child.stdin, msgspec.msgpack.encode(question(1)))
        assert read_frame(child.stdout)
        at_first = processor_ticks(child.pid)
        # It works while nobody asks.
        while processor_ticks(child.pid) <= at_first + 10:
            assert child.poll() is None
            os.sched_yield()
        if way == "asked":
            write_frame(child.stdin, msgspec.msgpack.encode(question(2)))
            answer = msgspec.msgpack.decode(read_frame(child.stdout) or b"", type=PlannerAnswer)
            assert answer.number == 2
            assert answer.request
        child.stdin.close()
        assert child.wait(PATIENCE_S) == 0


def processor_ticks(number: int) -> int:
    """Give the processor time of a process (hundredths of a second)."""
    words = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
    return int(words[11]) + int(words[12])


async def test_a_planner_that_is_killed_is_begun_anew_with_all_it_has_to_know() -> None:
    async with planner() as (process, told), asyncio.timeout(PATIENCE_S):
        process.take_setup(setup(request("a")))
        process.ask(question(1))
        assert (await told.get()).request == "a"
        os.kill(child_of_this_process(), signal.SIGKILL)
        # The question that meets the dead one is lost, and asked again by who waits for it.
        for number in range(2, 200):
            process.ask(question(number))
            try:
                answer = await asyncio.wait_for(told.get(), 2.0)
            except TimeoutError:
                continue
            assert answer.request == "a"
            return
    pytest.fail("no answer")
