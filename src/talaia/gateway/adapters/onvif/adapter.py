"""The ONVIF adapter: one network camera's pictures, motion, presets and how it stands.

Pictures are read as any RTSP camera's, and go on while its control is away. Whatever it was told
before, a camera that is reached is told to stop first.
"""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, TypeVar

from talaia.first_completed import until_first
from talaia.gateway.adapters.http.fetching import FetchFailed, ServerNotReached
from talaia.gateway.adapters.json_signals import JsonSignals
from talaia.gateway.adapters.onvif.answers import PtzStatus
from talaia.gateway.adapters.onvif.camera_server import OnvifServer
from talaia.gateway.adapters.onvif.pictures import pictures_of
from talaia.gateway.adapters.onvif.ptz_commands import CameraCommands, CameraOrder
from talaia.gateway.adapters.onvif.ptz_motion import PtzMotion
from talaia.gateway.adapters.onvif.ptz_service import PtzService, choose_profile
from talaia.gateway.adapters.onvif.ptz_view import PTZ_KEY, PtzView
from talaia.gateway.adapters.onvif.soap import CameraFault
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml
from talaia.gateway.adapters.undriven_adapter import JsonAdapter
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import CommandOutcome
from talaia.model.connection import (
    OnvifConnection,
    OnvifSource,
    source_as,
)
from talaia.model.connections.onvif import ONVIF_TRAVELS
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Coroutine

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.model.site import Signal
    from talaia.wire.frames import Scalar

__all__ = ["OnvifAdapter"]

_T = TypeVar("_T")
# Pace at which held-back values are given out (s).
_TURN_S = 0.1
# While it moves, and until it rests, it is asked so often how it stands (s).
_LIVELY_S = 0.25
# Presets change seldom, and mostly by us (s).
_PRESETS_S = 15.0
# While its control is away and pictures go on, it is tried again so often (s).
_AGAIN_S = 1.0


class _Control:
    """What there is while a camera is reached."""

    def __init__(
        self,
        service: PtzService,
        axes: frozenset[str],
        report: Callable[[str], None],
        *,
        moves: bool,
    ) -> None:
        self.service = service
        self.view = PtzView()
        self.motion = PtzMotion(service, axes, report, begins_with_stop=moves)
        self.commands = CameraCommands(service, self.motion, self.view)


class OnvifAdapter(JsonAdapter):
    """An `Adapter` for one camera; see `talaia.gateway.ports`."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what it serves, where things go, and where it says how its side stands."""
        settings = scope.connection
        assert isinstance(settings, OnvifConnection)  # noqa: S101 - the catalog has seen to it
        self._scope, self._settings, self._status = scope, settings, status
        self._clock, self._events, self._folder = context.clock, context.events, context.folder
        self._reports = UnreadableReports(context.events)
        signals = JsonSignals(scope, _place_of, self._reports.report_unreadable)
        super().__init__(signals, context.samples, "onvif")
        self._pictures = pictures_of(scope, settings, context)
        self._shows_presets = any(
            source_as(signal.source, OnvifSource).ptz == "presets"
            for device in scope.devices.values()
            for signal in device.signals.values()
        )
        # By device: the axes of its drive, in the order of its demands.
        self._axes = {
            name: tuple(device.drive.joints)
            for name, device in scope.devices.items()
            if device.drive is not None
        }
        # Whether anybody moves it from here; and whether more is asked of it than pictures.
        self._moves = bool(self._axes) or any(device.commands for device in scope.devices.values())
        self._is_ptz = self._moves or bool(signals.keys)
        self._control: _Control | None = None  # While the camera is reached.
        self._stopped: set[str] = set()  # Devices whose STOP is on.
        # Its control was away when `run` last ended; told already.
        self._is_lost = False

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        pictures = self._pictures
        await _run_together(self._keep_control(), *([] if pictures is None else [pictures.run()]))

    async def _keep_control(self) -> None:
        server = OnvifServer(self._settings, self._folder)
        try:
            profile = await self._reach_camera(server)
            self._is_lost = False
            control = None
            if profile is not None:
                axes = frozenset(axis for axes in self._axes.values() for axis in axes)
                service = PtzService(server, profile)
                control = self._control = _Control(
                    service, axes, self._report_camera, moves=self._moves
                )
            self._status.up()
            if control is None:
                await asyncio.Event().wait()
            else:
                await self._serve_control(control)
        except (FetchFailed, UnreadableXml, CameraFault) as error:
            self._is_lost = True
            raise AdapterLost(f"the camera {server.where}: {error}") from error
        finally:
            server.close()

    async def _reach_camera(self, server: OnvifServer) -> str | None:
        """Give the profile that is moved, or none where nothing is to be."""
        while True:
            try:
                await server.begin()
                return (
                    await choose_profile(server, self._settings.profile) if self._is_ptz else None
                )
            except (FetchFailed, UnreadableXml, CameraFault):
                # Told when it was lost; meanwhile its pictures may well go on.
                if not self._is_lost or self._pictures is None:
                    raise
            await asyncio.sleep(_AGAIN_S)

    async def _serve_control(self, control: _Control) -> None:
        try:
            await _run_together(
                control.motion.run(), self._poll_camera(control), self._publish_due()
            )
        finally:
            # By the time that `run` raises, all has been told.
            self._control = None
            control.commands.lose_all()
            self._signals.lose_key(PTZ_KEY, self._clock.wall_ns() // 1000)
            self._signals.forget_readings()
            self._publish_samples()

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        if self._pictures is not None:
            self._pictures.watch(streams)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        if self._control is None or device not in self._axes:
            return
        if self._stopped and demand.moves:
            # Another device of the same camera: what stops one stops it.
            return
        by_axis = dict(zip(self._axes[device], demand.joints, strict=False))
        pan, tilt, zoom = (by_axis.get(axis, 0.0) for axis in ("pan", "tilt", "zoom"))
        self._control.motion.demand((pan, tilt, zoom))

    def stop(self, device: str, *, stopped: bool) -> None:
        """Stop it, and let no command move it until STOP is released."""
        if not stopped:
            self._stopped.discard(device)
            return
        self._stopped.add(device)
        if self._control is not None:
            self._control.motion.stop_now()

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        described = self._scope.devices[device].commands[command]
        if self._control is None:
            done(CommandOutcome(CommandPhase.REFUSED, "the camera is not reached"))
            return None
        if self._stopped and described.target in ONVIF_TRAVELS:
            done(CommandOutcome(CommandPhase.REFUSED, "STOP is on"))
            return None
        preset = str(fields.get("preset", ""))
        order = CameraOrder(described.target, preset, described.timeout)
        return self._control.commands.begin_order(order, done)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Open its pictures anew, and say whether its control is there."""
        if self._pictures is not None:
            self._pictures.reconnect(device, lambda _outcome: None)
        if self._control is None and self._is_ptz:
            done(CommandOutcome(CommandPhase.FAILED, "the camera is not reached"))
        else:
            done(CommandOutcome(CommandPhase.SUCCEEDED))

    # ── what goes by time ──

    async def _poll_camera(self, control: _Control) -> None:
        loop = asyncio.get_running_loop()
        asked_at, presets_at, silent = -math.inf, -math.inf, 0
        while True:
            began = loop.time()
            if self._is_lively(control) or began - asked_at >= self._settings.poll:
                asked_at = began
                try:
                    if began - presets_at >= _PRESETS_S and self._shows_presets:
                        presets_at = began
                        control.view.presets = await self._ask_known(control.service.read_presets())
                    status = await self._ask_known(control.service.read_status())
                    control.view.see_status(status or PtzStatus())
                    silent = 0
                except ServerNotReached:
                    raise
                except FetchFailed:
                    # Once it may have been busy; whoever is silent twice is not there.
                    silent += 1
                    if silent > 1:
                        raise
                self._publish_view(control)
            await asyncio.sleep(max(0.0, began + _LIVELY_S - loop.time()))

    def _is_lively(self, control: _Control) -> bool:
        """Tell whether it moves, or has to come to rest."""
        moves = control.motion.was_driven_lately or control.view.moving is True
        return moves or control.commands.busy or bool(self._stopped)

    async def _ask_known(self, asking: Coroutine[object, object, _T]) -> _T | None:
        """Give what the camera answers; none where it has no answer to that."""
        try:
            return await asking
        except (CameraFault, UnreadableXml) as error:
            # Simple cameras have no status, or no presets: that is unknown then, and told once.
            self._reports.report_once(self._settings.url, str(error))
            return None

    def _publish_view(self, control: _Control) -> None:
        view = control.view
        if view.moving is not None:
            control.motion.heed_motion(moving=view.moving)
        time_us, mono_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
        self._signals.read_parsed(PTZ_KEY, view.payload(), time_us, mono_ns)
        self._publish_samples()

    async def _publish_due(self) -> None:
        while True:
            await asyncio.sleep(_TURN_S)
            self._signals.gather_due(self._clock.wall_ns() // 1000)
            self._publish_samples()

    def _report_camera(self, words: str) -> None:
        device = next(iter(self._axes or self._scope.devices), "")
        self._events.report_event("camera", words, device=device)


async def _run_together(*parts: Coroutine[object, object, None]) -> None:
    """Run all parts until cancelled, or until one fails: raise that."""
    for result in await until_first(*parts):
        if isinstance(result, BaseException) and not isinstance(result, asyncio.CancelledError):
            raise result


def _place_of(signal: Signal) -> tuple[str, str]:
    name = source_as(signal.source, OnvifSource).ptz
    return (PTZ_KEY, name) if name else ("", "")
