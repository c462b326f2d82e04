"""The client for scripts and notebooks: it waits where `AsyncClient` is awaited."""

from __future__ import annotations

from collections.abc import AsyncGenerator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Self, TypeVar

from talaia.client.async_client import AsyncClient
from talaia.client.event_loop_thread import EventLoopThread

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from talaia.client.drive_session import DriveSession
    from talaia.client.history_reading import HistoryForm
    from talaia.client.hub_location import HubLocation
    from talaia.client.times import Moment
    from talaia.client.values import (
        CommandProgress,
        CommandResult,
        DriveReport,
        Reading,
        RecordedFile,
        RecorderInfo,
        RecordingOverview,
        SiteInfo,
        SiteOverview,
    )

__all__ = ["Client", "DriveControl"]

T = TypeVar("T")


class Client:
    """A hub, by a person's token; see `AsyncClient`, whose methods these are.

    Use it as ``with Client() as hub: …``, or call `close` at the end.
    """

    def __init__(
        self, hub: str = "", token: str = "", *, fingerprint: str = "", ca: Path | str | None = None
    ) -> None:
        """Name a hub; what is left out comes from the environment or a file, see `find_hub`.

        Raises:
            BadSettings: no hub or no token is named, or one that cannot be meant.

        """
        # First: where it raises, no thread is left behind.
        self._client = AsyncClient(hub, token, fingerprint=fingerprint, ca=ca)
        self._thread = EventLoopThread()

    def __enter__(self) -> Self:
        """Give the client."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def close(self) -> None:
        """End what is still under way."""
        self._thread.stop_thread()

    @property
    def location(self) -> HubLocation:
        """Which hub it is, and how it is known."""
        return self._client.location

    def list_sites(self) -> list[SiteOverview]:
        """List the sites that the token may see."""
        return self._thread.run_coroutine(self._client.list_sites())

    def describe_site(self, site: str) -> SiteInfo:
        """Describe a site: its devices, with signals and commands, as far as the token sees it."""
        return self._thread.run_coroutine(self._client.describe_site(site))

    def read_values(self, addresses: Sequence[str]) -> list[Reading]:
        """Give the newest known value of each channel; what has never come is left out."""
        return self._thread.run_coroutine(self._client.read_values(addresses))

    def watch_values(
        self,
        addresses: Sequence[str],
        *,
        every_s: float = 0.1,
        report: Callable[[str], None] | None = None,
    ) -> Iterator[Reading]:
        """Give readings as they come; see `AsyncClient.watch_values`.

        ``report`` is called in another thread.
        """
        return self._wait_for_each(
            self._client.watch_values(addresses, every_s=every_s, report=report)
        )

    def read_history(
        self, signals: Sequence[str], since: Moment, until: Moment = "now", *, width: int = 0
    ) -> Any:  # noqa: ANN401 - pyarrow.Table
        """Read every stored sample as a `pyarrow.Table`; see `AsyncClient.read_history`."""
        return self._thread.run_coroutine(
            self._client.read_history(signals, since, until, width=width)
        )

    def stream_history(
        self, signals: Sequence[str], since: Moment, until: Moment = "now"
    ) -> Iterator[Any]:
        """Give the same as `pyarrow.RecordBatch` objects, for windows larger than the memory."""
        return self._wait_for_each(self._client.stream_history(signals, since, until))

    def save_history(
        self,
        path: Path | str,
        signals: Sequence[str],
        since: Moment,
        until: Moment = "now",
        *,
        form: HistoryForm = "parquet",
    ) -> int:
        """Save the same as a file, streamed; give its size in bytes."""
        return self._thread.run_coroutine(
            self._client.save_history(path, signals, since, until, form=form)
        )

    def call_command(
        self,
        command: str,
        arguments: Mapping[str, bool | float | str] | None = None,
        *,
        confirm: bool = False,
        over: str = "",
        timeout_s: float | None = None,
        report: Callable[[CommandProgress], None] | None = None,
    ) -> CommandResult:
        """Ask a device to do something once, and wait; see `AsyncClient.call_command`.

        ``report`` is called in another thread.
        """
        return self._thread.run_coroutine(
            self._client.call_command(
                command,
                arguments,
                confirm=confirm,
                over=over,
                timeout_s=timeout_s,
                report=report,
            )
        )

    @contextmanager
    def drive_device(self, device: str) -> Iterator[DriveControl]:
        """Take the control of a device for as long as the block lasts; see `AsyncClient`."""
        manager = self._client.drive_device(device)
        session = self._thread.run_coroutine(_enter(manager))
        try:
            yield DriveControl(session, self._thread)
        except BaseException as error:
            self._thread.run_coroutine(_leave(manager, error))
            raise
        else:
            self._thread.run_coroutine(_leave(manager, None))

    def press_stop(self, device: str) -> None:
        """Press STOP (software) of a device; see `AsyncClient.press_stop`."""
        self._thread.run_coroutine(self._client.press_stop(device))

    def list_recordings(self, site: str) -> RecordingOverview:
        """List a site's recordings, and tell how its recorder stands."""
        return self._thread.run_coroutine(self._client.list_recordings(site))

    def start_recording(self, site: str, *, why: str = "", stream: str = "") -> RecorderInfo:
        """Begin a recording, or the film of one camera (``device/stream``); wait until it runs."""
        return self._thread.run_coroutine(
            self._client.start_recording(site, why=why, stream=stream)
        )

    def stop_recording(self, site: str, *, stream: str = "") -> RecorderInfo:
        """End a recording, or a film; it comes to the hub after that."""
        return self._thread.run_coroutine(self._client.stop_recording(site, stream=stream))

    def wait_recording(
        self, site: str, recording: str, *, timeout_s: float = 600.0
    ) -> RecordedFile:
        """Wait until the whole of a recording is at the hub."""
        return self._thread.run_coroutine(
            self._client.wait_recording(site, recording, timeout_s=timeout_s)
        )

    def download_recording(
        self,
        site: str,
        recording: str,
        path: Path | str,
        *,
        report: Callable[[int], None] | None = None,
    ) -> int:
        """Save a recording as a file (MCAP, or MP4 of a film); give its size in bytes."""
        return self._thread.run_coroutine(
            self._client.download_recording(site, recording, path, report=report)
        )

    def _wait_for_each(self, stream: AsyncIterator[T]) -> Iterator[T]:
        try:
            while (found := self._thread.run_coroutine(_next_of(stream))) is not None:
                yield found
        finally:
            # Also when the script leaves its loop early.
            self._thread.run_coroutine(_close_stream(stream))


class DriveControl:
    """The control of one device, while a script has it; see `DriveSession`."""

    def __init__(self, session: DriveSession, thread: EventLoopThread) -> None:
        """Drive by ``session``, which lives in ``thread``."""
        self._session = session
        self._thread = thread

    @property
    def report(self) -> DriveReport:
        """What the device is being told, as far as it is known here."""
        return self._session.report

    def set_velocity(self, linear: float, angular: float = 0.0) -> DriveReport:
        """Move for 250 ms from now at ``linear`` m/s forward and ``angular`` rad/s to the left.

        Call it again before it has run out, such as ten times a second; nothing repeats it.

        Raises:
            DrivingRefused: not by this script, or no longer; the device stops.
            HubNotReached: the connection is lost; the device stops.
            BadSettings: no finite numbers.

        """
        return self._thread.run_coroutine(self._session.set_velocity(linear, angular))

    def drive_for(self, linear: float, angular: float = 0.0, *, seconds: float) -> None:
        """Move at a velocity for so long, then stop.

        Raises:
            DrivingRefused: not by this script, or no longer; the device stops.
            HubNotReached: the connection is lost; the device stops.
            BadSettings: no finite numbers.

        """
        self._thread.run_coroutine(self._session.drive_for(linear, angular, seconds=seconds))

    def stop_motion(self) -> None:
        """Stop now; the control stays."""
        self._thread.run_coroutine(self._session.stop_motion())


async def _enter(manager: AbstractAsyncContextManager[T]) -> T:
    return await manager.__aenter__()


async def _leave(manager: AbstractAsyncContextManager[object], error: BaseException | None) -> None:
    # As an error of its own: a KeyboardInterrupt would end the thread's event loop.
    shown = error if isinstance(error, Exception) or error is None else RuntimeError(repr(error))
    try:
        await manager.__aexit__(type(shown) if shown else None, shown, None)
    except Exception as raised:
        # What the block raised is raised by the caller; anything else is new.
        if raised is not shown:
            raise


async def _next_of(stream: AsyncIterator[T]) -> T | None:
    return await anext(stream, None)


async def _close_stream(stream: AsyncIterator[T]) -> None:
    if isinstance(stream, AsyncGenerator):
        await stream.aclose()
