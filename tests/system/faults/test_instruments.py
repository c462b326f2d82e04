"""The judge itself is judged: made-up ledgers with known breaches, and weather that repeats."""

from __future__ import annotations

import asyncio
import os

import pytest

from talaia.wire.frames import LINK_FROM_HUB, Ack

from . import crashing, ledgers
from .ledgers import MS, Said, Told
from .looker import COUNT, DOOR, Shown, differences
from .proxy import Proxy
from .weather import CALM, Dice, Frames, Way, Weather


def said(*values: int, known: int = 1, step: int = 5 * MS) -> list[Said]:
    return [Said(value, value * step, known) for value in values]


def test_a_value_that_is_nowhere_is_lost_unless_a_gap_tells_of_it() -> None:
    ten = said(*range(10))
    assert ledgers.lost(ten, [0, 1, 2, 4, 5, 6, 7, 8, 9]) == {3}
    assert ledgers.lost(ten, range(10)) == set()
    wall = {each.value: each.value * 10_000_000 for each in ten}
    assert ledgers.lost(ten, range(5), [(50_000_000, 80_000_000)], wall) == {9}


def test_a_value_that_stands_before_an_earlier_one_is_found() -> None:
    assert ledgers.disordered([1, 2, 4, 5]) == set()
    assert ledgers.disordered([1, 4, 2, 5, 6]) == {4}


def test_disagreement_on_the_last_value_is_found_wherever_it_is() -> None:
    same = {COUNT: (7.0, 70), DOOR: (11.0, 60)}
    shown = {COUNT: Shown(7.0, 70, 0.0), DOOR: Shown(11.0, 60, 5000.0)}
    expected = {COUNT: 7.0, DOOR: 11.0}
    assert differences(shown, "active", same, same, expected) == []
    assert len(differences(shown, "normal", same, same, expected)) == 1
    older = {**same, DOOR: (3.0, 50)}
    for last, history in ((older, same), (same, older)):
        assert len(differences(shown, "active", last, history, expected)) == 1
    assert len(differences({**shown, DOOR: Shown(3.0, 50, 0.0)}, "normal", same, same, {})) == 1
    assert len(differences(shown, "active", same, same, {DOOR: 12.0})) == 1


def test_what_is_stored_or_done_twice_is_found() -> None:
    assert ledgers.doubled([1, 2, 2, 3]) == {2}
    assert ledgers.repeated(["a", "b", "a"]) == {"a"}


def test_a_motion_that_is_old_or_that_nobody_pressed_is_found() -> None:
    pressed = {0.1: 0, 0.2: 100 * MS}
    told = [Told(50 * MS, 0.1, 0.0), Told(500 * MS, 0.2, 0.0), Told(501 * MS, 0.0, 0.0)]
    assert [age for _, age in ledgers.stale(told, pressed)] == [400.0]
    assert ledgers.stale([Told(1, 0.3, 0.0)], pressed)[0][1] == float("inf")


def test_the_time_to_stop_counts_to_the_zero_that_holds() -> None:
    told = [Told(100 * MS, 0.0, 0.0), Told(200 * MS, 0.1, 0.0), Told(300 * MS, 0.0, 0.0)]
    assert ledgers.stop_ms(told, 0) == 300
    assert ledgers.stop_ms(told[:2], 0) == float("inf")
    assert ledgers.moved_after(told, 150 * MS) == [told[1]]


def frame(payload: bytes) -> bytes:
    """A binary message in one frame, as a server sends it."""
    size = len(payload)
    return bytes([0x82, size]) + payload if size < 126 else b"\x82\x7e" + size.to_bytes(2) + payload


def test_a_motion_that_nothing_follows_is_found() -> None:
    told = [Told(0, 0.2, 0.0), Told(50 * MS, 0.2, 0.0), Told(1650 * MS, 0.0, 0.0)]
    # What is told after a zero may take its time.
    told.append(Told(9000 * MS, 0.1, 0.0))
    assert ledgers.left_moving(told) == [50.0, 1600.0]


def test_frames_are_found_however_the_bytes_are_cut() -> None:
    stream = b"GET / HTTP/1.1\r\n\r\n" + frame(b"x" * 5) + frame(b"y" * 300) + b"\x8a\x00"
    for cut in range(1, len(stream)):
        frames = Frames()
        found = [*frames.feed(stream[:cut]), *frames.feed(stream[cut:])]
        assert b"".join(piece for piece, _ in found) == stream
        assert [whole for _, whole in found] == [False, True, True, False]


def test_the_same_seed_decides_the_same() -> None:
    weather = Weather(duplicate=0.3, reorder=0.3, split=0.3)
    pieces = [bytes([number]) * 20 for number in range(50)]

    def dealt(seed: int) -> list[bytes]:
        dice = Dice(seed)
        return [*(bit for piece in pieces for bit in dice.deal(piece, True, weather)), *dice.last()]  # noqa: FBT003

    assert dealt(1) == dealt(1)
    assert dealt(1) != dealt(2)
    assert {*b"".join(dealt(1))} == {*range(50)}


async def test_in_the_dark_nothing_arrives_and_afterwards_all_of_it() -> None:
    async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while data := await reader.read(100):
            writer.write(data)
        writer.close()

    server = await asyncio.start_server(echo, "127.0.0.1", 0)
    proxy = await asyncio.to_thread(Proxy, server.sockets[0].getsockname()[1])
    try:
        reader, writer = await asyncio.open_connection("127.0.0.1", proxy.port)
        writer.write(b"hello\r\n\r\n")
        assert await reader.readexactly(9) == b"hello\r\n\r\n"
        message = frame(LINK_FROM_HUB.encode(Ack(boot="b", below=1)))
        await asyncio.to_thread(proxy.change, Weather(dark=frozenset([Way.DOWN])))
        writer.write(message)
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(reader.readexactly(1), 0.2)
        await asyncio.to_thread(proxy.change, CALM)
        assert await reader.readexactly(len(message)) == message
        await asyncio.to_thread(proxy.cut)
        assert await reader.read() == b""
        writer.close()
    except ConnectionError:
        pass
    finally:
        await asyncio.to_thread(proxy.close)
        server.close()


@pytest.mark.parametrize("point", sorted(crashing.POINTS))
def test_every_named_point_is_a_place_in_the_code(point: str) -> None:
    child = os.fork()
    if child == 0:
        try:
            crashing.arm(crashing.POINTS[point])
        except BaseException:  # noqa: BLE001 - told by the exit code
            os._exit(1)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_a_hole_in_the_robots_own_counting_is_the_machines() -> None:
    counted = [Said(each, at * MS, 1) for each, at in enumerate((0, 5, 10, 300, 305, 310))]
    assert ledgers.stall_ms(counted, 302 * MS) == 290
    assert ledgers.stall_ms(counted, 5000 * MS) == 0
