"""Driving one device from a script, by the rules for tools (safety rule 13, decision 79).

Each velocity is sent once and moves the device for 250 ms from its arrival at the hub: a script
that stands still, is killed or loses its line stops the vehicle by that alone. Nothing here repeats
a velocity that the script did not give for a stated time.
"""

from __future__ import annotations

import asyncio
import itertools
import math
import time
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

from talaia.client.addresses import find_device
from talaia.client.errors import BadSettings, ClientError, DrivingRefused, HubNotReached
from talaia.client.http_requests import quote_segment
from talaia.client.values import DriveReport
from talaia.wire.browser import (
    DriveUpdate,
    LeaseUpdate,
    PageDrive,
    PageLease,
    PagePing,
    PagePong,
    RequestError,
    SiteUpdate,
    StopUpdate,
)
from talaia.wire.frames import LeaseOp

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from talaia.client.hub_api import HubApi
    from talaia.client.page_socket import PageSocket
    from talaia.wire.browser import ToBrowser

__all__ = ["DriveSession", "open_drive"]

# How long the lease may take to come (s).
_LEASE_S = 10.0
# The line is measured so often, and with a longer round trip nothing is driven (s): what waited in
# it would move the device late.
_MEASURE_S = 0.2
_SLOWEST_S = 0.5
# `drive_for` gives its velocity so often: well within the 250 ms that each counts for (s).
_EVERY_S = 0.1
# The hub follows the last velocity with zeros by itself; these come sooner.
_ZEROS = 3


class DriveSession:
    """The control of one device, while a script has it."""

    def __init__(self, socket: PageSocket, site: str, device: str) -> None:
        """Drive ``device`` over ``socket``, which is for driving."""
        self._socket = socket
        self._site, self._device = site, device
        # Set by what the hub says; all but the first end this session for good.
        self._held = asyncio.Event()
        self._refused = ""
        self._lost: ClientError | None = None
        self._report = DriveReport()
        # Of the newest measurement that was not answered: its number, and when it was sent.
        self._unanswered: dict[int, float] = {}

    @property
    def report(self) -> DriveReport:
        """What the device is being told, as far as it is known here."""
        return self._report

    async def set_velocity(self, linear: float, angular: float = 0.0) -> DriveReport:
        """Move for 250 ms from now at ``linear`` m/s forward and ``angular`` rad/s to the left.

        The hub cuts it to half of the description's limits, and the gateway to what it allows now.
        Call it again before it has run out, such as ten times a second. On a line that takes longer
        than 500 ms nothing is sent; the report then says why.

        Raises:
            DrivingRefused: not by this script, or no longer; the device stops.
            HubNotReached: the connection is lost; the device stops.
            BadSettings: no finite numbers.

        """
        if not math.isfinite(linear) or not math.isfinite(angular):
            raise BadSettings(f"a velocity is two finite numbers, not {linear!r} and {angular!r}")
        self._check_control()
        if self._line_s() > _SLOWEST_S:
            why = f"the hub's answers take longer than {_SLOWEST_S * 1000:g} ms; nothing is sent"
            return self._report._replace(why=why)
        await self._send_velocity(linear, angular)
        return self._report

    async def drive_for(self, linear: float, angular: float = 0.0, *, seconds: float) -> None:
        """Move at a velocity for so long, then stop.

        Raises:
            DrivingRefused: not by this script, or no longer; the device stops.
            HubNotReached: the connection is lost; the device stops.
            BadSettings: no finite numbers.

        """
        if not math.isfinite(seconds) or seconds < 0:
            raise BadSettings(f"expected a time in seconds, found {seconds!r}")
        ends_s = time.monotonic() + seconds
        try:
            while (left_s := ends_s - time.monotonic()) > 0:
                await self.set_velocity(linear, angular)
                await asyncio.sleep(min(_EVERY_S, left_s))
        finally:
            await self.stop_motion()

    async def stop_motion(self) -> None:
        """Stop now; the control stays."""
        # Also on a line that is slow, and after a refusal: a zero is always good.
        with suppress(HubNotReached):
            for _ in range(_ZEROS):
                await self._send_velocity(0.0, 0.0)

    async def take_control(self) -> None:
        """Wait until the hub has the lease for this script.

        Raises:
            DrivingRefused: it does not get it.
            HubNotReached: the connection is lost.

        """
        await self._send_velocity(0.0, 0.0)
        with suppress(TimeoutError):
            async with asyncio.timeout(_LEASE_S):
                await self._held.wait()
        self._check_control()
        if not self._held.is_set():
            raise DrivingRefused(
                f"{self._site}/{self._device}: the gateway has not given control within"
                f" {_LEASE_S:g} s"
            )

    async def release_control(self) -> None:
        """Stop, and give the control back."""
        await self.stop_motion()
        with suppress(HubNotReached):
            await self._socket.send_message(
                PageLease(site=self._site, device=self._device, op=LeaseOp.FREE)
            )

    async def hear_hub(self) -> None:
        """Hear what the hub says of this drive, until it is lost."""
        try:
            while True:
                self._observe(await self._socket.receive_message())
        except ClientError as error:
            self._lost = error
            self._held.set()

    async def measure_line(self) -> None:
        """Measure how long the hub's answers take, until cancelled."""
        for number in itertools.count(1):
            self._unanswered[number] = time.monotonic()
            with suppress(HubNotReached):
                # Whoever hears the hub is told of the loss.
                await self._socket.send_message(PagePing(n=number, at_ms=0.0))
            await asyncio.sleep(_MEASURE_S)

    async def _send_velocity(self, linear: float, angular: float) -> None:
        # The hub numbers the frames of its own lease, and echoes the gateway's marks.
        await self._socket.send_message(
            PageDrive(
                site=self._site,
                device=self._device,
                epoch=0,
                seq=0,
                tick=0,
                linear=linear,
                angular=angular,
            )
        )

    def _check_control(self) -> None:
        if self._lost is not None:
            raise self._lost
        if self._refused:
            raise DrivingRefused(self._refused)

    def _line_s(self) -> float:
        """Give how long the oldest measurement without an answer is under way."""
        oldest = min(self._unanswered.values(), default=math.inf)
        return max(0.0, time.monotonic() - oldest)

    def _observe(self, message: ToBrowser) -> None:
        match message:
            case PagePong():
                # Answers come in order: what was asked before is answered, too.
                answered = [number for number in self._unanswered if number <= message.n]
                for number in answered:
                    del self._unanswered[number]
            case LeaseUpdate(device=self._device, yours=True):
                self._held.set()
            case DriveUpdate(device=self._device):
                self._report = self._report._replace(
                    linear=message.linear,
                    angular=message.angular,
                    cap=message.cap,
                    why=message.why,
                )
            case StopUpdate(device=self._device):
                self._report = self._report._replace(stopped=message.latched)
            case SiteUpdate(site=self._site, online=False):
                self._refuse(f"{self._site}: its gateway is not connected")
            case RequestError(about="drive" | "lease"):
                self._refuse(message.message)
            case _:
                pass

    def _refuse(self, why: str) -> None:
        # The first reason stays.
        self._refused = self._refused or why
        self._held.set()


@asynccontextmanager
async def open_drive(api: HubApi, address: str) -> AsyncIterator[DriveSession]:
    """Take the control of a device (``site/device``) for as long as the block lasts.

    However it ends, by an error or by Ctrl-C, zeros go out and the control is given back.

    Raises:
        ProtocolShut: an admin has to open driving by scripts.
        DrivingRefused: an admin does not let this account drive the device by scripts, or somebody
            else has the control.
        ClientError: the hub cannot be asked, or says no.

    """
    site, device_id = address.split("/")
    device = find_device(await api.describe_site(site), device_id)
    if device.drive is None:
        raise DrivingRefused(f"{address} is nothing that is driven")
    path = f"/clients/scripts/{quote_segment(site)}"
    async with api.open_socket(path, needs=f"the right use of {address}") as socket:
        session = DriveSession(socket, site, device_id)
        tasks = [
            asyncio.create_task(session.hear_hub()),
            asyncio.create_task(session.measure_line()),
        ]
        try:
            await session.take_control()
            yield session
        finally:
            # Also while this is being cancelled: the control must not stay.
            await asyncio.shield(session.release_control())
            for task in tasks:
                task.cancel()
