"""The thread in which an observatory lives through its nights, each on a clock of its own."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import queue
import secrets
import threading
import time
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from talaia.cli.demo.in_process_observatory import InProcessObservatory
from talaia.cli.demo.time_lapse.night_span import NightSpan, next_night
from talaia.cli.demo.time_lapse.sample_feed import SampleFeed
from talaia.cli.demo.time_lapse.simulated_gateway import HubSide, SimulatedGateway
from talaia.clock import SECOND, HandClock
from talaia.simulated_time import SimulatedLoop
from talaia.wire.frames import NightArmRequest, NightPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from talaia.gateway.ports import SampleSink
    from talaia.model.site import Site
    from talaia.wire.frames import FromHub

__all__ = ["LapseSettings", "LapseThread"]

log = logging.getLogger(__name__)
# Of the simulator, and the least that time moves by (s).
STEP_S = 1.0
# The night's state is told so often for its time alone (s, real).
REPEAT_S = 1.0
# A night that has begun so short a time ago is armed itself, and not the next one (s).
FRESH_S = 1800.0
# It lingers so long behind the end of a night before its time is real time again (s).
LINGER_S = 900.0


class LapseSettings(NamedTuple):
    """How nights are lived through.

    Attributes:
        speed: so many times as fast as real time, while the night is armed.
        hours: only the last hours of each night; 0: all of it.
        seed: of the weather.

    """

    speed: float = 150.0
    hours: float = 0.0
    seed: int = 1


class LapseThread:
    """Messages go in from any thread, and come out by `HubSide`.

    Before the night is armed, and behind its end, time goes by as fast as it really does. Who arms
    it begins the next night: a night's clock never goes back.
    """

    def __init__(
        self,
        *,
        site: Site,
        numbers: Mapping[str, int],
        samples: SampleSink,
        hub: HubSide,
        data: Path,
        settings: LapseSettings,
        failed: Callable[[], None],
    ) -> None:
        """Begin nothing yet; ``failed`` is called, from its thread, if it ends by a fault.

        Raises:
            ValueError: the site has no place.

        """
        if site.place is None:
            raise ValueError(f"{site.site} has no place")
        self._site, self._place, self._hub = site, site.place, hub
        self._data, self._settings, self._failed = data, settings, failed
        self._feed = SampleFeed(site, numbers, samples)
        # What came from the hub: a message, or whether the link stands.
        self._inbox: queue.SimpleQueue[FromHub | bool] = queue.SimpleQueue()
        self._linked = False
        # That of the present night; replaced by the thread, used by others to wake it.
        self._loop: SimulatedLoop | None = None
        # Who arms the next night.
        self._arming: NightArmRequest | None = None
        # The night has not gone on much, nobody has armed it; it passes at high speed.
        self._fresh, self._fast = True, False
        self._ending = False
        self._monotonic_ns = time.monotonic_ns()
        self._thread = threading.Thread(target=self._live, name="time lapse", daemon=True)

    def start(self) -> None:
        """Begin to live."""
        self._thread.start()

    def close(self) -> None:
        """End it, and wait for that."""
        self._ending = True
        self._wake_loop()
        self._thread.join()

    def take_message(self, message: FromHub | bool) -> None:  # noqa: FBT001 - link up, or lost
        """Take a message of the hub, or whether the link stands."""
        self._inbox.put(message)
        self._wake_loop()

    def _wake_loop(self) -> None:
        loop = self._loop
        if loop is not None:
            # Closed in this very moment: the next one looks into the inbox by itself.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(_nothing)

    # ── in the thread ──

    def _live(self) -> None:
        try:
            lived = self._read_lived()
            while not self._ending:
                night = next_night(self._place, max(time.time(), lived), self._settings.hours)
                self._live_night(night)
                lived = night.ends
        except Exception:
            log.exception("the time lapse failed")
            self._failed()

    def _live_night(self, night: NightSpan) -> None:
        clock = HandClock(round(night.begins * SECOND), self._monotonic_ns)
        with asyncio.Runner(loop_factory=lambda: SimulatedLoop(clock, STEP_S)) as runner:
            loop = runner.get_loop()
            if not isinstance(loop, SimulatedLoop):
                raise TypeError("expected a simulated loop")
            self._loop = loop
            try:
                runner.run(self._follow_night(loop, night))
            finally:
                self._loop = None
        self._monotonic_ns = clock.monotonic_ns()

    async def _follow_night(self, loop: SimulatedLoop, night: NightSpan) -> None:
        """Live until the end, or until somebody arms the next one."""
        clock, settings = loop.clock, self._settings
        robot = InProcessObservatory(self._site, clock, seed=settings.seed)
        robot.step()
        gateway = SimulatedGateway(
            site=self._site,
            clock=clock,
            robot=robot,
            hub=self._hub,
            data=self._data,
            boot=f"{time.time_ns() // 1_000_000:012x}-{secrets.token_hex(4)}",
            speed=settings.speed,
        )
        judge = gateway.actuation.interlocks.conditions
        # Its looks are a second apart, and no standstill.
        loop.passing = lambda: judge.mark_running(clock.monotonic_ns())
        loop.pace_time(1.0)
        gateway.start()
        if self._linked:
            gateway.link_up()
        arming, self._arming = self._arming, None
        self._fresh, self._fast = True, False
        if arming is not None:
            self._arm_night(gateway, loop, night, arming)
        begun, told = False, 0.0
        try:
            while not self._ending and self._arming is None:
                self._take_inbox(gateway, loop, night)
                await _pass_step()
                robot.step()
                self._feed.give_values(robot, clock.wall_ns() // 1000)
                if time.monotonic() - told >= REPEAT_S:
                    told = time.monotonic()
                    gateway.repeat_state()
                now = clock.wall_ns() / SECOND
                self._fresh = self._fresh and now < night.begins + FRESH_S
                # Fast until it has been armed and is so no more.
                begun = begun or gateway.phase is not NightPhase.DISARMED
                ended = begun and gateway.phase is NightPhase.DISARMED and _at_rest(robot)
                if self._fast and (ended or now > night.ends + LINGER_S):
                    self._fast = False
                    loop.pace_time(1.0)
        finally:
            loop.passing = _nothing
            await gateway.close()

    def _arm_night(
        self,
        gateway: SimulatedGateway,
        loop: SimulatedLoop,
        night: NightSpan,
        arming: NightArmRequest,
    ) -> None:
        """Let it run, at high speed and to its own end."""
        self._fresh, self._fast = False, True
        loop.pace_time(self._settings.speed)
        gateway.handle_message(replace(arming, until=night.ends))
        self._write_lived(night.ends)

    def _take_inbox(self, gateway: SimulatedGateway, loop: SimulatedLoop, night: NightSpan) -> None:
        while self._arming is None:
            try:
                message = self._inbox.get_nowait()
            except queue.Empty:
                return
            if isinstance(message, bool):
                self._linked = message
                if message:
                    gateway.link_up()
                else:
                    gateway.link_lost()
            elif isinstance(message, NightArmRequest) and gateway.phase is NightPhase.DISARMED:
                if self._fresh:
                    self._arm_night(gateway, loop, night, message)
                else:
                    self._arming = message
            else:
                gateway.handle_message(message)

    # Nights lived through before: the site's time never goes back.

    def _read_lived(self) -> float:
        with contextlib.suppress(OSError, ValueError):
            return float((self._data / "lived_until").read_text())
        return 0.0

    def _write_lived(self, until: float) -> None:
        (self._data / "lived_until").write_text(f"{until:.0f}")


def _at_rest(robot: InProcessObservatory) -> bool:
    closed, state = robot.latest("dome/closed"), robot.latest("telescope/state")
    return closed is not None and closed.value == 1.0 and state is not None and state.value == 0.0


async def _pass_step() -> None:
    """Let a step of simulated time pass."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(STEP_S):
            await asyncio.get_running_loop().create_future()


def _nothing() -> None: ...
