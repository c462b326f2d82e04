"""Features open in their order, close in the reverse one, and no background task dies unseen."""

from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S

from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.lifecycle import open_features

# Before a task that died begins again.
SHORT_S = 0.001


class Diary:
    """What happened, in its order; and the core, which is opened first and closed last."""

    def __init__(self):  # noqa: D107
        self.lines = []
        self.news = asyncio.Event()

    def write(self, line):
        self.lines.append(line)
        self.news.set()

    async def reads(self, line, times=1):
        async with asyncio.timeout(PATIENCE_S):
            while self.lines.count(line) < times:
                self.news.clear()
                await self.news.wait()

    async def open(self):
        self.write("core opens")

    async def close(self):
        self.write("core closes")


class Kept(Feature):
    """A feature that writes down what is done to it."""

    def __init__(self, name, diary, *, opens=True, tasks=()):  # noqa: D107
        self.name, self.diary, self.opens, self.tasks = name, diary, opens, tasks

    async def open(self):
        if not self.opens:
            raise RuntimeError(self.name)
        self.diary.write(f"{self.name} opens")

    async def close(self):
        self.diary.write(f"{self.name} closes")


async def test_features_open_in_order_and_close_in_reverse():
    diary = Diary()
    async with open_features(diary, [Kept("first", diary), Kept("second", diary)]):
        diary.write("serves")
    assert diary.lines == [
        "core opens", "first opens", "second opens", "serves",
        "second closes", "first closes", "core closes",
    ]  # fmt: skip


async def test_a_feature_that_cannot_open_closes_those_before_it():
    diary = Diary()
    with pytest.raises(RuntimeError, match="second"):
        async with open_features(diary, [Kept("first", diary), Kept("second", diary, opens=False)]):
            diary.write("serves")
    assert diary.lines == ["core opens", "first opens", "first closes", "core closes"]


async def test_a_task_ends_before_its_feature_closes_and_writes_what_waits():
    diary, stopping = Diary(), asyncio.Event()

    async def work():
        diary.write("works")
        await stopping.wait()
        diary.write("writes the rest")

    tasks = [BackgroundTask(name="work", run=work, stop=stopping.set)]
    async with open_features(diary, [Kept("first", diary, tasks=tasks), Kept("second", diary)]):
        await diary.reads("works")
    assert diary.lines[-4:] == [
        "second closes", "writes the rest", "first closes", "core closes",
    ]  # fmt: skip


async def test_a_task_without_a_stop_is_cancelled():
    diary = Diary()

    async def work():
        diary.write("works")
        try:
            await asyncio.Event().wait()
        finally:
            diary.write("is cancelled")

    async with open_features(
        diary, [Kept("first", diary, tasks=[BackgroundTask(name="work", run=work)])]
    ):
        await diary.reads("works")
    assert diary.lines[-3:] == ["is cancelled", "first closes", "core closes"]


async def test_a_task_that_dies_is_logged_by_name_and_begins_again(caplog):
    diary = Diary()

    async def work():
        diary.write("works")
        if diary.lines.count("works") < 3:
            raise ValueError("no luck")
        await asyncio.Event().wait()

    tasks = [BackgroundTask(name="work", run=work)]
    async with open_features(diary, [Kept("first", diary, tasks=tasks)], SHORT_S):
        await diary.reads("works", times=3)
        names = {task.get_name() for task in asyncio.all_tasks()}
    assert "first: work" in names
    assert caplog.text.count("the background task 'first: work' died") == 2
    assert "no luck" in caplog.text


async def test_a_task_that_died_writes_what_waits_before_it_ends():
    diary, stopping = Diary(), asyncio.Event()

    async def work():
        diary.write("works")
        if not stopping.is_set():
            raise ValueError("no luck")
        diary.write("writes the rest")

    tasks = [BackgroundTask(name="work", run=work, stop=stopping.set)]
    async with open_features(diary, [Kept("first", diary, tasks=tasks)], PATIENCE_S):
        await diary.reads("works")
    assert diary.lines[-3:] == ["writes the rest", "first closes", "core closes"]
