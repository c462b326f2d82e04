"""The Alpaca adapter: devices of one ASCOM Alpaca server as signals, commands and pictures.

Each device is asked by a task of its own, so that one that hangs holds up no other. A server that
is not reached ends `run` at once: everything is unknown then, and nothing under way is repeated.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.gateway.adapters.alpaca.camera_pictures import CameraPictures
from talaia.gateway.adapters.alpaca.commands_under_way import AlpacaCommands, call_of
from talaia.gateway.adapters.alpaca.device_poll import DevicePoll
from talaia.gateway.adapters.alpaca.discovery import device_of, unique_word
from talaia.gateway.adapters.alpaca.found_devices import ask_device, list_devices
from talaia.gateway.adapters.alpaca.goals import stop_of
from talaia.gateway.adapters.alpaca.protocol import AlpacaRefused
from talaia.gateway.adapters.alpaca.server import AlpacaServer
from talaia.gateway.adapters.http.fetching import FetchFailed, ServerNotReached
from talaia.gateway.adapters.json_signals import JsonSignals
from talaia.gateway.adapters.undriven_adapter import JsonAdapter
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import CommandOutcome
from talaia.model.connection import (
    AlpacaConnection,
    AlpacaSource,
    alpaca_device_of,
    source_as,
)
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.model.site import Device, Signal
    from talaia.wire.frames import Scalar

__all__ = ["AlpacaAdapter"]

log = logging.getLogger(__name__)
# Pace at which held-back values are given out.
_TURN_S = 0.1
# After so many times what is waited for an answer; who hangs is not asked all the time.
_LOOK_AGAIN = 3.0


class AlpacaAdapter(JsonAdapter):
    """An `Adapter` for the devices of one Alpaca server; see `talaia.gateway.ports`."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what it serves, where things go, and where it says how its side stands."""
        settings = scope.connection
        assert isinstance(settings, AlpacaConnection)  # noqa: S101 - the catalog has seen to it
        self._scope, self._settings, self._status = scope, settings, status
        self._clock, self._events = context.clock, context.events
        unreadable = UnreadableReports(context.events)
        signals = JsonSignals(scope, _place_of, unreadable.report_unreadable)
        super().__init__(signals, context.samples, "alpaca")
        # By the device in the description: the Alpaca devices that it stands for.
        self._parts = {name: _alpaca_devices(device) for name, device in scope.devices.items()}
        devices = dict.fromkeys(part for parts in self._parts.values() for part in parts)
        self._polls = {device: self._poll_of(device) for device in devices}
        self._commands = AlpacaCommands(context.clock, CameraPictures(devices, context.files))
        self._server: AlpacaServer | None = None  # While it is asked.

    def _poll_of(self, device: str) -> DevicePoll:
        ages: dict[str, float] = {}
        aged: set[str] = set()
        for described in self._scope.devices.values():
            for signal in described.signals.values():
                source = source_as(signal.source, AlpacaSource)
                key = source.property
                if not key or alpaca_device_of(key) != device:
                    continue
                ages[key] = min(ages.get(key, signal.stale_after), signal.stale_after)
                if source.age:
                    aged.add(key)
        return DevicePoll(
            device,
            ages,
            aged=frozenset(aged),
            signals=self._signals,
            clock=self._clock,
            connect=self._settings.connect,
            complain=self._report_problem,
        )

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        server = AlpacaServer(self._settings)
        tasks: list[asyncio.Task[None]] = []
        where = f"the Alpaca server {server.where}"
        try:
            try:
                # The first question; who has no such list answers all the same.
                await server.list_devices()
            except (FetchFailed, AlpacaRefused) as error:
                raise AdapterLost(f"{where} cannot be used: {error}") from error
            self._server = server
            for poll in self._polls.values():
                poll.restart()
            self._status.up()
            work = [self._poll_device(server, poll) for poll in self._polls.values()]
            if self._settings.discover:
                work.append(self._find_devices(server))
            work.append(self._publish_due())
            tasks = [asyncio.ensure_future(one) for one in work]
            await _first_failure(tasks)
        except FetchFailed as error:
            raise AdapterLost(f"{where} was lost: {error}") from error
        finally:
            self._server = None
            for task in tasks:
                task.cancel()
            # Before anything is awaited: by the time that `run` raises, all has been told.
            self._commands.lose_all()
            for poll in self._polls.values():
                poll.lose_all("the Alpaca server is not reached")
            self._signals.forget_readings()
            self._publish_samples()
            await asyncio.gather(*tasks, return_exceptions=True)
            server.close()

    def stop(self, device: str, *, stopped: bool) -> None:
        """Abort whatever the device is doing."""
        server = self._server
        # ASCOM knows no state of being stopped, so there is nothing to release.
        if server is None or not stopped:
            return
        for part in self._parts.get(device, ()):
            if target := stop_of(part):
                self._commands.stop_device(server, target)

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        described = self._scope.devices[device].commands[command]
        poll = self._polls.get(alpaca_device_of(described.target))
        connects = described.target.endswith("/connected")
        if self._server is None or poll is None:
            done(CommandOutcome(CommandPhase.REFUSED, "the Alpaca server is not connected"))
            return None
        if poll.why and not connects:
            done(CommandOutcome(CommandPhase.REFUSED, f"{poll.device}: {poll.why}"))
            return None
        if connects:
            # Who disconnects a device by hand must not find it connected again by us.
            poll.connect = fields.get("Connected") is True
        call = call_of(device, described.target, fields, described.timeout)
        return self._commands.begin_call(self._server, call, done)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Say how the newest answers were, and let each device be told to connect again."""
        if self._server is None:
            done(CommandOutcome(CommandPhase.FAILED, "the Alpaca server is not connected"))
            return
        parts = [self._polls[part] for part in self._parts.get(device, ())]
        for poll in parts:
            poll.connect = self._settings.connect
        wrong = [f"{poll.device}: {poll.why}" for poll in parts if poll.why]
        phase = CommandPhase.FAILED if wrong else CommandPhase.SUCCEEDED
        done(CommandOutcome(phase, "; ".join(wrong)[:2000]))

    # ── what goes by time ──

    async def _poll_device(self, server: AlpacaServer, poll: DevicePoll) -> None:
        loop = asyncio.get_running_loop()
        while True:
            began = loop.time()
            await poll.ask_once(server)
            self._publish_samples()
            self._report_devices(poll.device)
            await asyncio.sleep(max(0.0, began + self._settings.poll - loop.time()))

    async def _publish_due(self) -> None:
        while True:
            await asyncio.sleep(_TURN_S)
            self._signals.gather_due(self._clock.wall_ns() // 1000)
            self._publish_samples()

    async def _find_devices(self, server: AlpacaServer) -> None:
        """Tell once of what the server has and the description does not name."""
        again_s, said = _LOOK_AGAIN * self._settings.timeout, ""
        while True:
            try:
                found = await self._ask_for_others(server)
            except ServerNotReached:
                raise
            except (FetchFailed, AlpacaRefused) as error:
                # Those that are described go on. Who hangs, or was late once, is asked again.
                if str(error) != said:
                    said = str(error)
                    log.warning(
                        "looking for Alpaca devices at %s ended: %s; trying again every %g s",
                        server.where,
                        error,
                        again_s,
                    )
                await asyncio.sleep(again_s)
                continue
            if found:
                self._status.found(found)
            return

    async def _ask_for_others(self, server: AlpacaServer) -> dict[str, Device]:
        """Ask every device that the description does not name what it is, by words for them."""
        named = {part for parts in self._parts.values() for part in parts}
        found: dict[str, Device] = {}
        for one in await list_devices(server, self._settings.devices):
            if one.device in named:
                continue
            if self._settings.connect:
                await _connect_device(server, one.device)
            answers = await ask_device(server, one)
            word = unique_word(one.device.replace("/", "_"), {*self._scope.devices, *found})
            found[word] = device_of(answers, self._scope.name)
        return found

    def _report_devices(self, part: str) -> None:
        for device, parts in self._parts.items():
            if part not in parts:
                continue
            wrong = [self._polls[one].why for one in parts]
            # One good part of each is enough: what the others had to say is unknown by itself.
            there = "" in wrong
            self._status.device(device, there=there, why="" if there else wrong[0][:200])

    def _report_problem(self, key: str, problem: str) -> None:
        device = next(
            (name for name, parts in self._parts.items() if alpaca_device_of(key) in parts), ""
        )
        self._events.report_event("unreadable", f"{key}: {problem}", device=device)


def _place_of(signal: Signal) -> tuple[str, str]:
    return source_as(signal.source, AlpacaSource).property, ""


def _alpaca_devices(device: Device) -> tuple[str, ...]:
    """Name the Alpaca devices that a described device reads and calls."""
    sources = (source_as(signal.source, AlpacaSource) for signal in device.signals.values())
    addresses = [source.property for source in sources if source.property]
    addresses += [command.target for command in device.commands.values()]
    return tuple(dict.fromkeys(alpaca_device_of(address) for address in addresses))


async def _first_failure(tasks: list[asyncio.Task[None]]) -> None:
    """Wait until a task fails, and raise that; one that only ends is no failure."""
    waiting = set(tasks)
    while waiting:
        done, waiting = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()


async def _connect_device(server: AlpacaServer, device: str) -> None:
    """Have a device tell what it has: most say little before they are connected."""
    try:
        if await server.ask_property(f"{device}/connected") is not True:
            await server.put_method(f"{device}/connected", {"Connected": True}, 60.0)
    except AlpacaRefused as error:
        log.info("%s does not connect: %s", device, error)
