"""The gateway put together: a table of parts that start in order and close in reverse."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.gateway.assembly.actuation import ActuationPart
from talaia.gateway.assembly.adapters import AdaptersPart
from talaia.gateway.assembly.description import DescriptionPart
from talaia.gateway.assembly.detection import DetectionPart
from talaia.gateway.assembly.foundation import FoundationPart
from talaia.gateway.assembly.legacy import LegacyPart
from talaia.gateway.assembly.night import NightPart
from talaia.gateway.assembly.notices import NoticesPart
from talaia.gateway.assembly.recording import RecordingPart
from talaia.gateway.assembly.reload import ReloadPart
from talaia.gateway.assembly.robot_log import RobotLogPart
from talaia.gateway.assembly.samples import SamplesPart
from talaia.gateway.assembly.supervision import SupervisionPart
from talaia.gateway.assembly.taps import TapsPart
from talaia.gateway.assembly.updates import UpdatesPart
from talaia.gateway.assembly.uplink import UplinkPart
from talaia.gateway.assembly.video import VideoPart
from talaia.service_manager import ServiceManager

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.clock import Clock
    from talaia.gateway.assembly.gateway_part import GatewayPart
    from talaia.gateway.reload.description_file import DescriptionFile
    from talaia.gateway.settings import GatewaySettings
    from talaia.model.site import Site

__all__ = ["Gateway"]

log = logging.getLogger(__name__)
# A zero velocity needs so long to leave for the robot.
HALT_S = 0.05


class Gateway:
    """All parts of one gateway, built for one event loop.

    Attributes:
        recording: what records.
        legacy: the WebSocket API of the founding observatory, where it is asked for.

    """

    def __init__(
        self,
        *,
        site: Site,
        settings: GatewaySettings,
        clock: Clock,
        file: DescriptionFile | None = None,
        manager: ServiceManager | None = None,
    ) -> None:
        """Build every part, with what an earlier run left; with no ``file`` nothing is redescribed.

        Raises:
            SpoolError: the data folder cannot be used.
            SettingsError: the description names a connection that cannot be used here.

        """
        # Built and started in this order, closed in reverse.
        self._parts: tuple[GatewayPart, ...] = (
            base := FoundationPart(settings=settings, clock=clock),
            description := DescriptionPart(base=base, site=site, file=file),
            samples := SamplesPart(base=base, description=description),
            recording := RecordingPart(base=base, description=description),
            taps := TapsPart(base=base),
            robot_log := RobotLogPart(base=base),
            video := VideoPart(base=base, description=description, recording=recording, taps=taps),
            adapters := AdaptersPart(
                base=base,
                description=description,
                samples=samples,
                recording=recording,
                video=video,
                taps=taps,
                robot_log=robot_log,
            ),
            detection := DetectionPart(
                base=base, description=description, samples=samples, video=video, adapters=adapters
            ),
            actuation := ActuationPart(
                base=base, description=description, adapters=adapters, detection=detection
            ),
            legacy := LegacyPart(
                base=base,
                description=description,
                samples=samples,
                adapters=adapters,
                actuation=actuation,
            ),
            supervision := SupervisionPart(
                base=base,
                description=description,
                adapters=adapters,
                actuation=actuation,
                manager=(service := manager or ServiceManager()),
            ),
            reload := ReloadPart(
                base=base,
                description=description,
                samples=samples,
                recording=recording,
                adapters=adapters,
                detection=detection,
                actuation=actuation,
                legacy=legacy,
                supervision=supervision,
            ),
            night := NightPart(base=base, description=description, actuation=actuation),
            uplink := UplinkPart(
                base=base,
                samples=samples,
                video=video,
                adapters=adapters,
                detection=detection,
                actuation=actuation,
                reload=reload,
                night=night,
            ),
            UpdatesPart(base=base, description=description, uplink=uplink),
            NoticesPart(base=base, description=description, adapters=adapters, uplink=uplink),
        )
        self._manager, self._supervision, self.recording = service, supervision, recording
        self._restart, self._actuation, self.legacy = description.restart, actuation, legacy

    @property
    def redescribed(self) -> Site | None:
        """The description to begin again with, after `run`; none at the end."""
        return self._restart.site

    async def run(self, ended: asyncio.Event) -> None:
        """Run until ``ended`` is set, or there is a new description; then stop and close all.

        A part that fails ends the gateway, and is raised when all others have closed.
        """
        # Before anything here moves: two must never move a roof.
        await self._supervision.take_over()
        # All are started before any task runs: no task meets a part that is not ready.
        for part in self._parts:
            part.start()
        tasks = [
            asyncio.create_task(_until_cancelled(run), name=f"{part.name}: {name}")
            for part in self._parts
            for name, run in part.tasks().items()
        ]
        # Only now: a service manager may begin what needs this gateway.
        self._manager.report_ready()
        asked = asyncio.create_task(ended.wait(), name="end asked for")
        # Waits until nothing moves, so a restart never cuts off a motion.
        due = asyncio.create_task(
            self._restart.wait_due(self._actuation.is_busy), name="restart due"
        )
        try:
            # Any end of a task ends the gateway: one that guards and is gone must not go unnoticed.
            await asyncio.wait([asked, due, *tasks], return_when=asyncio.FIRST_COMPLETED)
        # Also when `run` itself is cancelled.
        finally:
            asked.cancel()
            due.cancel()
            # The zero goes out while there is still an adapter to carry it.
            self._actuation.halt_all()
            await asyncio.sleep(HALT_S)
            # An adapter that ends has no readings any more: that is no unsafe weather.
            self._actuation.stop_judging()
            failures = await _end_tasks(tasks)
            if not failures:
                # One that ends by a fault of its own says no goodbye: its roof is closed. Nor does
                # one that begins anew: dead before it has, it leaves a watchdog behind.
                if ended.is_set():
                    await self._supervision.say_goodbye()
                else:
                    self._supervision.leave_watchdog()
            await self.close()
        # The first is the cause as a rule; all of them are in the log.
        if failures:
            raise failures[0]

    async def close(self) -> None:
        """Release everything; what waits is on disk then."""
        for part in reversed(self._parts):
            # One after the other: a part may use those before it until it is closed.
            await part.close()


async def _until_cancelled(run: Callable[[], Awaitable[None]]) -> None:
    with contextlib.suppress(asyncio.CancelledError):
        await run()


async def _end_tasks(tasks: list[asyncio.Task[None]]) -> list[Exception]:
    """Cancel all, the last begun first, and wait for them; give what they failed of."""
    for task in reversed(tasks):
        task.cancel()
    results = await asyncio.gather(*tasks, return_exceptions=True)
    failures = []
    for task, result in zip(tasks, results, strict=True):
        if isinstance(result, Exception):
            log.error("%s failed: %s", task.get_name(), result)
            failures.append(result)
    return failures
