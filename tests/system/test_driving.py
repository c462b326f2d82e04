"""Driving through the real chain, and everything that must stop it.

Hub, gateway and ROS 2 are the real ones; a robot writes down when which velocity reached it.
``TALAIA_FAULT_TRIES=10`` repeats what is timed, and ``-s`` shows the times.

Long, because a guest looks on through all of it, and is asked at the end what there was to see.
"""

from __future__ import annotations

import json
import math
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from talaia.wire import browser

from .conftest import running_stack
from .people import Guest, Page, page
from .stack import DESCRIPTION, SITE, Heard, Stack, until

pytestmark = pytest.mark.robot

TRIES = int(os.environ.get("TALAIA_FAULT_TRIES", "1"))
timed = pytest.mark.parametrize("turn", range(TRIES))
BOUND_MS = 500.0
SILENCE_NS = 300_000_000
# What a hub read of people's rights it trusts for two seconds; it reads them each half second.
UNSURE_NS = 1_300_000_000
# What was published just before a process died still arrives.
UNDER_WAY_NS = 100_000_000


class Times:
    """How long it took to stop, by what happened (ms)."""

    def __init__(self) -> None:
        """Begin with none."""
        self._found: dict[str, list[float]] = {}

    def add(self, what: str, ms: float) -> None:
        self._found.setdefault(what, []).append(ms)
        assert ms <= BOUND_MS, f"{what}: stopped after {ms:.0f} ms"

    def show(self) -> None:
        for what, found in self._found.items():
            found.sort()
            middle = found[len(found) // 2]
            sys.stdout.write(
                f"\n{what:<44} n={len(found):<3} min {found[0]:5.0f}  median {middle:5.0f}"
                f"  max {found[-1]:5.0f} ms"
            )


@pytest.fixture(scope="module")
def times() -> Iterator[Times]:
    kept = Times()
    yield kept
    kept.show()


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    """Start one with the longest lease: it does not end while the test is kept waiting.

    A frame under a lease that has ended is refused for that, and its age is not looked at.
    """
    longer = DESCRIPTION.replace(
        "      topic: /cmd_vel\n", "      topic: /cmd_vel\n      lease: 10\n"
    )
    assert longer != DESCRIPTION
    with running_stack(tmp_path_factory, longer) as started:
        yield started


@pytest.fixture(scope="module", autouse=True)
def guest(stack: Stack) -> Iterator[Guest]:
    """Look on while everything happens."""
    watching = Guest(stack)
    yield watching
    watching.close()


def now() -> int:
    return time.monotonic_ns()


def moving(heard: list[Heard]) -> list[Heard]:
    return [each for each in heard if each.v[:2] != [0.0, 0.0]]  # type: ignore[index]


async def drive(stack: Stack, driver: Page, topic: str = "/cmd_vel") -> None:
    """Take the lease and press until the robot is told to move."""
    began = now()
    assert (await driver.take()).yours
    driver.press(0.3)
    await until(lambda: moving(stack.heard(topic, began)), what="the robot told to move")


async def standstill(stack: Stack, at: int) -> float:
    """Wait until the robot hears nothing any more; give when it was told zero after ``at`` (ms)."""

    def silent() -> bool:
        # A motion is not the last: zeros follow it, however late a busy machine sends them.
        heard = stack.heard("/cmd_vel", at)
        return bool(heard) and not moving(heard[-1:]) and now() - heard[-1].t > SILENCE_NS

    await until(silent, what="silence after the zeros")
    heard = stack.heard("/cmd_vel", at)
    last = moving(heard)[-1].t if moving(heard) else at
    zeros = [each for each in heard if each.t > last]
    # One second at 20 Hz, less what a busy machine lets slip.
    assert len(zeros) >= 10
    return (zeros[0].t - at) / 1e6


@timed
async def test_when_the_hub_is_killed_the_robot_is_told_zero_and_needs_a_new_press(
    stack: Stack, times: Times, turn: int
) -> None:
    await stack.fresh()
    async with page(stack, "driver") as driver:
        await drive(stack, driver)
        links = stack.gateway.said().count("linked to")
        at = stack.hub.kill()
        times.add("hub killed while driving", await standstill(stack, at))
        # At once, and not for want of frames or at the end of the lease.
        await stack.gateway.says("drive_ended base link lost")
    stack.start_hub()
    await stack.gateway.says("linked to", times=links + 1)
    async with page(stack, "driver") as again:
        assert (await again.sees(browser.LeaseUpdate, lambda x: x.device == "base")).holder == ""
        await again.sees(browser.StopUpdate, lambda x: x.device == "base" and not x.latched)
        for frame in driver.sent[-5:]:
            await again.say(frame)
        await again.sees(browser.DriveUpdate, lambda x: "nobody holds" in x.why)
        await again.take()
        since = len(again.got)
        for frame in driver.sent[-5:]:
            await again.say(frame)
        await again.sees(browser.DriveUpdate, lambda x: "earlier lease" in x.why, since=since)
        assert moving(stack.heard("/cmd_vel", at + round(BOUND_MS * 1e6))) == []
        await drive(stack, again)
        await again.let_go()
        await again.free()


def _is_refusal(message: browser.ToBrowser, *, by_hub: bool) -> bool:
    if by_hub and isinstance(message, browser.RequestError):
        return message.about == "drive"
    return isinstance(message, browser.DriveUpdate) and "too old" in message.why


@timed
async def test_frames_that_waited_in_a_frozen_hub_never_move_the_robot(
    stack: Stack, times: Times, turn: int
) -> None:
    await stack.fresh()
    async with page(stack, "driver") as driver:
        await drive(stack, driver)
        at = now()
        stack.hub.popen.send_signal(signal.SIGSTOP)
        try:
            await until(lambda: now() - at > 1_000_000_000, 5)
            await driver.vanish()
            pressed = len(driver.sent)
            since = len(driver.got)
        finally:
            stack.hub.popen.send_signal(signal.SIGCONT)
        froze_ns = now() - at
        times.add("hub frozen while driving", await standstill(stack, at))
        # The answer to a ping comes behind all that waited in the socket.
        await driver.say(browser.PagePing(n=1, at_ms=0.0))
        await driver.sees(browser.PagePong)
        # A hub that slept for longer is no longer sure of anybody's rights, and refuses by itself.
        await until(
            lambda: any(
                _is_refusal(each, by_hub=froze_ns > UNSURE_NS) for each in driver.got[since:]
            ),
            what=f"a refusal after {froze_ns / 1e9:.1f} s (got: {driver.got[since:]})",
        )
        assert pressed > 15
        assert moving(stack.heard("/cmd_vel", at + round(BOUND_MS * 1e6))) == []
        await driver.free()


@timed
async def test_frames_that_waited_in_a_frozen_gateway_never_move_the_robot(
    stack: Stack, turn: int
) -> None:
    await stack.fresh()
    async with page(stack, "driver") as driver:
        await drive(stack, driver)
        at = now()
        stack.gateway.popen.send_signal(signal.SIGSTOP)
        try:
            # It cannot speak; what the robot hears of it now was on its way. A page that has to
            # wait for a core sends frames late, and without some that wait nothing is refused.
            pressed = len(driver.sent)
            await until(lambda: now() - at > 1_000_000_000 and len(driver.sent) > pressed + 5)
            await driver.vanish()
        finally:
            stack.gateway.popen.send_signal(signal.SIGCONT)
        since = len(driver.got)

        def answered() -> bool:
            # Of several answers that wait for a busy hub only the newest is sent; it counts them
            # all. On a machine so slow that the lease ran out meanwhile, nobody counts frames.
            return any(
                (isinstance(told, browser.DriveUpdate) and told.refused > 0)
                or (isinstance(told, browser.LeaseUpdate) and not told.yours)
                for told in driver.got[since:]
            )

        await until(answered, what="what waited is refused, or the lease is over")
        await standstill(stack, at)
        assert moving(stack.heard("/cmd_vel", at + SILENCE_NS)) == []
        await driver.free()


@timed
async def test_when_the_gateway_is_killed_the_robots_own_time_out_stops_it(
    stack: Stack, times: Times, turn: int, tmp_path: Path
) -> None:
    await stack.fresh()
    log = tmp_path / "actuations.jsonl"
    vehicle = stack.start_vehicle(log)

    def acted(since: int) -> list[dict[str, object]]:
        lines = [json.loads(line) for line in log.read_text().splitlines()]
        return [each for each in lines if each["monotonic_ns"] > since]

    try:
        await vehicle.says('"ready": true')
        await stack.fresh()
        async with page(stack, "driver") as driver:
            began = now()
            await drive(stack, driver)
            # The first thing that a lease says may be zero, and who rests needs no time-out.
            await until(
                lambda: any(each["v"] for each in acted(began)[-1:]), what="the vehicle moves"
            )
            at = stack.gateway.kill()

            def rests() -> bool:
                last = acted(began)[-1]
                return (last["v"], last["w"]) == (0.0, 0.0)

            await until(rests, what="the vehicle's time-out")
            stop = acted(began)[-1]
            # Where a busy machine kept frames waiting, it may have timed out just before the kill,
            # or the gateway may have stopped it.
            assert stop["source"] == "timeout" or stop["monotonic_ns"] <= at  # type: ignore[operator]
            assert len(acted(at)) <= 1
            times.add("gateway killed: vehicle's own time-out", (stop["monotonic_ns"] - at) / 1e6)  # type: ignore[operator]
            since = len(driver.got)
            stack.start_gateway()
            await stack.ready()
            # The page still holds the key down, and nobody has the lease.
            await driver.sees(browser.DriveUpdate, lambda x: "nobody holds" in x.why, since=since)
            lease = await driver.sees(browser.LeaseUpdate, since=since)
            assert (lease.holder, lease.yours) == ("", False)
            assert moving(stack.heard("/cmd_vel", at + UNDER_WAY_NS)) == []
            # A gateway that gets no link soon enough says zero; nothing else is ever obeyed.
            assert {(each["v"], each["w"]) for each in acted(at)} == {(0.0, 0.0)}
    finally:
        vehicle.end()


@timed
async def test_a_page_that_falls_silent_stops_the_robot_and_its_old_frames_are_refused(
    stack: Stack, times: Times, turn: int
) -> None:
    await stack.fresh()
    async with page(stack, "driver") as driver:
        await drive(stack, driver)
        await driver.vanish()
        times.add("page silent, socket open", await standstill(stack, driver.last_frame_ns))
        old, at = driver.sent[-1], now()
        for changed, why in (
            ({}, "repeated or out of order"),
            ({"seq": old.seq + 100}, "too old"),
            ({"seq": old.seq + 101, "tick": driver.tick + 10_000}, "never sent"),
            ({"seq": old.seq + 102, "epoch": old.epoch - 1, "tick": driver.tick}, "earlier"),
        ):
            since = len(driver.got)
            await driver.say(browser.PageDrive(**{**_fields(old), **changed}))
            await driver.sees(browser.DriveUpdate, lambda x, w=why: w in x.why, since=since)
        assert moving(stack.heard("/cmd_vel", at)) == []
        await driver.free()


def _fields(frame: browser.PageDrive) -> dict[str, object]:
    return {name: getattr(frame, name) for name in frame.__struct_fields__}


async def press_stop(stack: Stack, by: Page, name: str) -> float:
    """Press STOP; give when the robot was told zero and nothing else since (ms)."""
    at = now()
    await by.say(browser.PageStop(site=SITE, device="base", id=name))
    await by.sees(browser.StopUpdate, lambda x: x.id == name and x.latched)
    await until(lambda: any(x.v is True for x in stack.heard("/stop", at)), what="the stop topic")
    # The robot itself stands still, which the site's own reading proves.
    await by.sees(browser.StopUpdate, lambda x: x.latched and x.confirmed)
    heard = stack.heard("/cmd_vel", at)
    last = moving(heard)[-1].t if moving(heard) else at
    return (next(each.t for each in heard if each.t > last) - at) / 1e6


async def reset_stop(driver: Page) -> None:
    """Release STOP in its two steps."""
    about = {"site": SITE, "device": "base", "epoch": driver.epoch}
    since = len(driver.got)
    await driver.say(browser.PageReset(**about))
    key = await driver.sees(browser.ResetTokenUpdate, since=since)
    assert key.token
    await driver.say(browser.PageReset(**about, token=key.token))
    await driver.sees(browser.StopUpdate, lambda x: not x.latched, since=since)


@timed
async def test_anybody_may_stop_it_and_it_stays_so_over_a_crash_until_the_driver_resets_it(
    stack: Stack, times: Times, turn: int
) -> None:
    await stack.fresh()
    async with page(stack, "driver") as driver, page(stack, "second") as second:
        await drive(stack, driver)
        ms = await press_stop(stack, second, f"stop-{turn}")
        times.add("STOP by another person", ms)
        at = now()
        if turn == 0:
            await second.say(browser.PageReset(site=SITE, device="base", epoch=driver.epoch))
            assert "holds the lease" in (await second.sees(browser.ResetTokenUpdate)).refused
        killed = stack.gateway.kill()
        since, since_second = len(driver.got), len(second.got)
        stack.start_gateway()
        await stack.ready()
        await second.sees(browser.StopUpdate, lambda x: x.latched, since=since_second)
        await until(
            lambda: any(x.v is True for x in stack.heard("/stop", killed)),
            10, "STOP told to the robot again",
        )  # fmt: skip
        assert (await driver.take()).yours
        await driver.sees(browser.DriveUpdate, lambda x: "STOP is on" in x.why, since=since)
        about = {"site": SITE, "device": "base", "epoch": driver.epoch}
        await driver.say(browser.PageReset(**about, token="guessed"))  # noqa: S106
        refusal = await driver.sees(browser.ResetTokenUpdate, lambda x: x.refused, since=since)
        assert "begin again" in refusal.refused
        since = len(driver.got)
        await reset_stop(driver)
        # Still held down, as it was all the time.
        await driver.sees(browser.DriveUpdate, lambda x: "let go first" in x.why, since=since)
        assert moving(stack.heard("/cmd_vel", at)) == []
        await driver.let_go()
        driver.press(0.3)
        await until(lambda: moving(stack.heard("/cmd_vel", at)), what="driving after the reset")
        await driver.let_go()
        await driver.free()


async def test_numbers_that_are_none_and_numbers_beyond_the_limits_never_reach_the_robot(
    stack: Stack,
) -> None:
    await stack.fresh()
    async with page(stack, "driver") as driver:
        await driver.take()
        at = now()
        for wish in (math.nan, math.inf, -math.inf):
            since = len(driver.got)
            await driver.frame(wish)
            await driver.sees(browser.RequestError, lambda x: x.code == "invalid", since=since)
            await driver.frame(0.0, wish)
        await driver.let_go()
        driver.press(1e300, -1e9)
        await until(lambda: moving(stack.heard("/cmd_vel", at)))
        await driver.vanish()
        await standstill(stack, driver.last_frame_ns)
        assert {tuple(each.v) for each in stack.heard("/cmd_vel", at)} == {(0.0, 0.0), (0.5, -1.0)}  # type: ignore[arg-type]
        await driver.free()


async def test_a_stamped_robot_hears_its_message_without_anybodys_clock(stack: Stack) -> None:
    await stack.fresh()
    at = now()
    async with page(stack, "driver", device="stamped") as driver:
        await drive(stack, driver, "/cmd_stamped")
        await until(lambda: any(x.v[0] == 0.3 for x in stack.heard("/cmd_stamped", at)))  # type: ignore[index]
        await driver.let_go()
        await driver.sees(browser.DriveUpdate, lambda x: x.device == "stamped" and x.linear == 0)
        await until(lambda: stack.heard("/cmd_stamped")[-1].v == [0.0, 0.0, 0.0])
        await driver.free()
    assert {each.v[2] for each in stack.heard("/cmd_stamped", at)} == {0.0}  # type: ignore[index]
    # Of the other vehicle's last drive some zeros may still be on their way.
    assert {tuple(each.v) for each in stack.heard("/cmd_vel", at)} <= {(0.0, 0.0)}  # type: ignore[arg-type]


async def test_a_robot_of_keys_hears_the_keys_and_at_the_end_s(stack: Stack) -> None:
    await stack.fresh()
    at = now()
    async with page(stack, "driver", device="keys") as driver:
        await driver.take()
        for wish, key in (
            ((0.3, 0.0), "w"),
            ((-0.3, 0.0), "x"),
            ((0.0, 0.8), "a"),
            ((0.0, -0.8), "d"),
        ):
            driver.press(*wish)
            await until(
                lambda k=key: stack.heard("/control", at) and stack.heard("/control")[-1].v == k,
                5,
                key,
            )
            await driver.vanish()
        await driver.let_go()
        await until(lambda: stack.heard("/control")[-1].v == "s")
        await driver.free()
    assert stack.heard("/control")[-1].v == "s"
    assert {each.v for each in stack.heard("/control", at)} == {*"wxads"}


async def test_metric_texts_become_samples_in_either_quotes(stack: Stack) -> None:
    await stack.fresh()
    async with page(stack, "second") as second:
        assert (await second.subscribe("base/wheel1")).refused == []
        texts = ["{'name': 'wheel1', 'magnitude': 1.25}", '{"name": "wheel1", "magnitude": -2.5}']
        texts.append("{'name': 'other1', 'magnitude': 9.0}")

        def told() -> bool:
            for text in texts:
                stack.robot.tell(f"metric {text}")
            return {1.25, -2.5} <= set(second.values())

        await until(told, what="both magnitudes")
        assert set(second.values()) == {1.25, -2.5}


async def test_a_guest_who_looked_on_all_the_time_was_told_what_is_public_and_nothing_else(
    stack: Stack, guest: Guest
) -> None:
    await stack.fresh()
    before = len(guest.got)
    await until(lambda: len(guest.got) > before + 20, what="values for the guest")
    got = list(guest.got)
    kinds = {type(each) for each in got}
    assert kinds <= {
        browser.Greeting,
        browser.SiteUpdate,
        browser.Subscribed,
        browser.Values,
        browser.RequestError,
    }
    subscribed = [each for each in got if isinstance(each, browser.Subscribed)]
    assert subscribed
    assert all(each.refused == ["base/count"] for each in subscribed)
    problems = [each for each in got if isinstance(each, browser.RequestError)]
    assert {each.code for each in problems} == {"forbidden"}
    assert {each.about for each in problems} == {"lease", "drive", "stop", "reset", "command"}
    assert {each.role for each in got if isinstance(each, browser.Greeting)} == {"guest"}
