"""What the database keeps of robots' own logs, on every kind of database."""

from __future__ import annotations

import pytest

from talaia.clock import HandClock
from talaia.hub.store.sites.robot_log import LogFilter, RobotLogStore, StoredLine


def line(time_us: int, text: str, *, level: int = 30, node: str = "lidar", left_out: int = 0):
    return StoredLine(time_us, level, node, text, "spin", "/src/node.cpp", 7, left_out)


@pytest.fixture
def store(database) -> RobotLogStore:
    return RobotLogStore(database, HandClock())


async def found(store: RobotLogStore, limit: int = 10, **wanted: object) -> list[str]:
    page = await store.find_lines("agv", LogFilter(**wanted), limit)
    return [one.body.text for one in page.lines]


async def test_each_line_is_kept_once_and_found_by_time_level_node_and_words(store) -> None:
    lines = [
        line(1000, "50% of the beams\nare blind ✓"),
        line(2000, "pump is dry", level=40, node="tank.pump"),
        line(3000, "12 lines were left out", left_out=12, node=""),
    ]
    assert await store.store_lines("agv", "run", 0, lines[:2]) == 2
    # Its acknowledgement was lost: it comes again, with what came since.
    assert await store.store_lines("agv", "run", 0, lines) == 1
    assert await store.store_lines("agv", "run", 1, lines[1:]) == 0
    assert await store.store_lines("moon", "run", 0, [line(1500, "elsewhere")]) == 1
    beams, pump, left_out = (one.text for one in lines)
    assert await found(store) == [left_out, pump, beams]
    assert await found(store, from_us=1000, to_us=1999) == [beams]
    # That something is missing is of every level and node.
    assert await found(store, level=40) == [left_out, pump]
    assert await found(store, node="lidar") == [left_out, beams]
    assert await found(store, text="BLIND 50%") == [beams]
    assert await found(store, text="5%b") == []
    assert await found(store, text="tank.PUMP") == [pump]
    assert await store.list_nodes("agv") == ["lidar", "tank.pump"]


async def test_pages_neither_repeat_nor_skip_a_line_and_a_search_goes_on(
    database,
) -> None:
    store = RobotLogStore(database, HandClock(), most_searched=4)
    # All in one microsecond.
    lines = [line(5000, f"{'odd' if number % 6 else 'sixth'} {number}") for number in range(13)]
    await store.store_lines("agv", "run", 0, lines)
    for text, expected in (("", lines), ("sixth", [lines[0], lines[6], lines[12]])):
        seen, place = [], None
        for _ in range(9):
            page = await store.find_lines("agv", LogFilter(text=text, before=place), 2)
            seen += [one.body.text for one in page.lines]
            place = page.after
            if place is None:
                break
        assert seen == [one.text for one in reversed(expected)]
        assert place is None


async def test_what_is_old_or_too_much_goes(store) -> None:
    await store.store_lines("agv", "run", 0, [line(number, f"{number}") for number in range(9)])
    await store.store_lines("moon", "run", 0, [line(1, "alone")])
    assert await store.delete_old(0, 6) == 3
    assert await store.delete_old(5, 100) == 3
    assert await found(store) == ["8", "7", "6", "5"]
    # What went does not come again.
    assert await store.store_lines("agv", "run", 0, [line(0, "0")]) == 0
