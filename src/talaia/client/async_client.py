"""The client for programs with an event loop of their own."""

from __future__ import annotations

import asyncio
import secrets
from contextlib import aclosing, asynccontextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from talaia.client import history_reading, recording_requests
from talaia.client.command_call import call_command
from talaia.client.drive_session import open_drive
from talaia.client.errors import BadSettings, HubNotReached, RequestRefused
from talaia.client.history_reading import HistoryWindow
from talaia.client.hub_api import HubApi
from talaia.client.hub_location import find_hub
from talaia.client.times import parse_moment
from talaia.client.value_watch import ValueWatch
from talaia.wire.browser import PageStop, RequestError, StopUpdate

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Mapping, Sequence

    from talaia.client.drive_session import DriveSession
    from talaia.client.history_reading import HistoryForm
    from talaia.client.hub_location import HubLocation
    from talaia.client.times import Moment
    from talaia.client.values import (
        CommandProgress,
        CommandResult,
        Reading,
        RecordedFile,
        RecorderInfo,
        RecordingOverview,
        SiteInfo,
        SiteOverview,
    )

__all__ = ["AsyncClient"]

# STOP is repeated so often until the gateway has it, and for so long (s).
_STOP_EVERY_S = 0.5
_STOP_S = 10.0


class AsyncClient:
    """A hub, by a person's token. Nothing is open between two calls.

    What an address may be: ``site/device/name``, or ``device/name`` where the token sees one site;
    see `talaia.client`. All methods raise `ClientError` where the hub cannot be asked, or says no.
    """

    def __init__(
        self, hub: str = "", token: str = "", *, fingerprint: str = "", ca: Path | str | None = None
    ) -> None:
        """Name a hub; what is left out comes from the environment or a file, see `find_hub`.

        Args:
            hub: ``https://host:port``.
            token: made under *Account → Tokens for scripts*.
            fingerprint: SHA-256 of the hub's certificate or public key; empty: by an authority.
            ca: file of certificate authorities (PEM); none takes the system's.

        Raises:
            BadSettings: no hub or no token is named, or one that cannot be meant.

        """
        authority = Path(ca) if ca is not None else None
        self._api = HubApi(find_hub(hub, token, fingerprint=fingerprint, ca=authority))

    @property
    def location(self) -> HubLocation:
        """Which hub it is, and how it is known."""
        return self._api.hub

    # ── what there is ──

    async def list_sites(self) -> list[SiteOverview]:
        """List the sites that the token may see."""
        return await self._api.list_sites()

    async def describe_site(self, site: str) -> SiteInfo:
        """Describe a site: its devices, with signals and commands, as far as the token sees it."""
        return await self._api.describe_site(site)

    # ── values ──

    async def read_values(self, addresses: Sequence[str]) -> list[Reading]:
        """Give the newest known value of each channel; what has never come is left out."""
        qualified = await self._api.qualify_addresses(_as_list(addresses))
        return await ValueWatch(self._api, qualified, every_ms=0).read_once()

    async def watch_values(
        self,
        addresses: Sequence[str],
        *,
        every_s: float = 0.1,
        report: Callable[[str], None] | None = None,
    ) -> AsyncIterator[Reading]:
        """Give readings as they come, for as long as they are read: the newest known ones first.

        What becomes stale is given once more, with the reason in ``stale``. A connection that is
        lost is made again; all is stale until then.

        Args:
            addresses: of signals or channels; ``*`` and ``?`` stand for other letters.
            every_s: at most so often for each channel, spikes kept; 0: every sample.
            report: is told in words when the connection is lost, and when it is back.

        """
        qualified = await self._api.qualify_addresses(_as_list(addresses))
        every_ms = round(min(max(every_s, 0.0), 60.0) * 1000)
        watch = ValueWatch(self._api, qualified, every_ms=every_ms, report=report)
        async with aclosing(watch.readings()) as readings:
            async for reading in readings:
                yield reading

    # ── history ──

    async def read_history(
        self, signals: Sequence[str], since: Moment, until: Moment = "now", *, width: int = 0
    ) -> Any:  # noqa: ANN401 - pyarrow.Table
        """Read every stored sample of some signals of one site as a `pyarrow.Table`.

        One row for each time stamp, one column for each channel. ``.to_pandas()`` gives a frame,
        where pandas is installed.

        Args:
            signals: addresses of signals or channels, also of ones that are described no more.
            since: a datetime, seconds since the epoch, or a text as ``2h``; see `parse_moment`.
            until: the same; not included.
            width: above 0, only what a chart of so many pixels shows, spikes kept.

        """
        window = await self._window_of(signals, since, until, width=width)
        return await history_reading.read_table(self._api, window)

    async def stream_history(
        self, signals: Sequence[str], since: Moment, until: Moment = "now"
    ) -> AsyncIterator[Any]:
        """Give the same as `pyarrow.RecordBatch` objects, for windows larger than the memory."""
        window = await self._window_of(signals, since, until)
        async with aclosing(history_reading.stream_batches(self._api, window)) as batches:
            async for batch in batches:
                yield batch

    async def save_history(
        self,
        path: Path | str,
        signals: Sequence[str],
        since: Moment,
        until: Moment = "now",
        *,
        form: HistoryForm = "parquet",
    ) -> int:
        """Save the same as a file, streamed; give its size in bytes."""
        window = await self._window_of(signals, since, until)
        return await history_reading.save_file(self._api, Path(path), window, form=form)

    # ── commands ──

    async def call_command(
        self,
        command: str,
        arguments: Mapping[str, bool | float | str] | None = None,
        *,
        confirm: bool = False,
        over: str = "",
        timeout_s: float | None = None,
        report: Callable[[CommandProgress], None] | None = None,
    ) -> CommandResult:
        """Ask a device to do something once, and wait for what becomes of it.

        It is sent once. Where the connection is lost after that, the result is ``unknown``: nothing
        is sent again by itself.

        Args:
            command: ``site/device/command``.
            arguments: by name, in the units of the description.
            confirm: a command that people are asked to confirm is meant.
            over: the id of somebody else's command that this may interrupt (`blocked_by`).
            timeout_s: how long to wait; by default for as long as the description allows.
            report: is told how far it is.

        """
        (address,) = await self._api.qualify_addresses([command])
        return await call_command(
            self._api,
            address,
            arguments or {},
            confirm=confirm,
            over=over,
            timeout_s=timeout_s,
            report=report,
        )

    # ── driving ──

    @asynccontextmanager
    async def drive_device(self, device: str) -> AsyncIterator[DriveSession]:
        """Take the control of a device (``site/device``) for as long as the block lasts.

        An admin has to open *Driving by scripts* and to let the account drive the device (*Admin →
        Clients*). See `DriveSession` for what moves it, and for how long.
        """
        (address,) = await self._api.qualify_addresses([device], parts=2)
        async with open_drive(self._api, address) as session:
            yield session

    async def press_stop(self, device: str) -> None:
        """Press STOP (software) of a device: it stays stopped until a person resets it at a page.

        Raises:
            HubNotReached: the gateway has not confirmed it; press the robot's own stop.

        """
        (address,) = await self._api.qualify_addresses([device], parts=2)
        site, _, name = address.partition("/")
        press = PageStop(site=site, device=name, id=f"script-{secrets.token_hex(8)}")
        unsure = f"{address} has not confirmed STOP; use the robot's own stop"
        try:
            async with asyncio.timeout(_STOP_S), self._api.open_socket("/ws") as socket:
                while True:
                    await socket.send_message(press)
                    try:
                        async with asyncio.timeout(_STOP_EVERY_S):
                            while True:
                                message = await socket.receive_message()
                                if isinstance(message, StopUpdate) and message.id == press.id:
                                    return
                                if isinstance(message, RequestError) and message.about == "stop":
                                    raise RequestRefused(message.code, message.message, unsure)
                    except TimeoutError:
                        continue
        except TimeoutError as error:
            raise HubNotReached(unsure) from error

    # ── recordings ──

    async def list_recordings(self, site: str) -> RecordingOverview:
        """List a site's recordings, and tell how its recorder stands."""
        return await recording_requests.overview_of(self._api, site)

    async def start_recording(self, site: str, *, why: str = "", stream: str = "") -> RecorderInfo:
        """Begin a recording, or the film of one camera (``device/stream``); wait until it runs."""
        return await recording_requests.ask_recorder(
            self._api, site, on=True, why=why, stream=stream
        )

    async def stop_recording(self, site: str, *, stream: str = "") -> RecorderInfo:
        """End a recording, or a film; it comes to the hub after that."""
        return await recording_requests.ask_recorder(
            self._api, site, on=False, why="", stream=stream
        )

    async def wait_recording(
        self, site: str, recording: str, *, timeout_s: float = 600.0
    ) -> RecordedFile:
        """Wait until the whole of a recording is at the hub."""
        return await recording_requests.wait_complete(
            self._api, site, recording, timeout_s=timeout_s
        )

    async def download_recording(
        self,
        site: str,
        recording: str,
        path: Path | str,
        *,
        report: Callable[[int], None] | None = None,
    ) -> int:
        """Save a recording as a file (MCAP, or MP4 of a film); give its size in bytes."""
        return await recording_requests.download_recording(
            self._api, site, recording, path=Path(path), report=report
        )

    async def _window_of(
        self, signals: Sequence[str], since: Moment, until: Moment, *, width: int = 0
    ) -> HistoryWindow:
        qualified = await self._api.qualify_addresses(_as_list(signals))
        sites = {address.partition("/")[0] for address in qualified}
        if len(sites) != 1:
            raise BadSettings("the history is read of one site at a time")
        now = datetime.now(UTC)
        since_us, until_us = parse_moment(since, now), parse_moment(until, now)
        if since_us >= until_us:
            raise BadSettings(f"since ({since}) must be before until ({until})")
        local = [address.partition("/")[2] for address in qualified]
        return HistoryWindow(sites.pop(), local, since_us, until_us, width)


def _as_list(addresses: Sequence[str]) -> list[str]:
    # A text is a sequence, too: of letters.
    found = [addresses] if isinstance(addresses, str) else list(addresses)
    if not found:
        raise BadSettings("name at least one signal")
    return found
