"""How often the ROS 2 thread takes what came: seldom, unless somebody looks."""

from __future__ import annotations

import math
from types import SimpleNamespace

from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread


def thread_told(paces: list[float]) -> WaitThread:
    return WaitThread(
        make_wait_set=lambda *_: None,
        guard=None,
        after=lambda: False,
        idle=lambda: None,
        failed=lambda _: None,
        paced=paces.append,
    )


def test_the_shortest_turns_that_anybody_asks_for_count() -> None:
    paces: list[float] = []
    thread = thread_told(paces)
    thread.shorten_turns("signals", 0.010)
    thread.shorten_turns("taps", 0.002)
    thread.shorten_turns("signals", math.inf)
    thread.shorten_turns("taps", math.inf)
    assert paces == [0.010, 0.002, 0.020]


def test_while_pictures_are_taken_turns_are_shorter() -> None:
    paces: list[float] = []
    thread = thread_told(paces)
    handles = [SimpleNamespace(pointer=number, take_message=print) for number in range(3)]
    thread.add_subscription(handles[0], None, print)
    assert paces == []
    thread.add_subscription(handles[1], None, print, large=True)
    thread.add_subscription(handles[2], None, print, large=True)
    assert paces == [0.010]
    thread.remove_subscription(handles[1])
    thread.remove_subscription(handles[0])
    assert paces == [0.010]
    thread.remove_subscription(handles[2])
    assert paces == [0.010, 0.020]
