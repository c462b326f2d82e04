"""The promises between the parts: what an adapter gives and what is asked of a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.wire.columns import Columns
    from talaia.wire.frames import CommandPhase, Picture

__all__ = [
    "Adapter",
    "CommandTarget",
    "EventSink",
    "Outcome",
    "PictureSink",
    "Reading",
    "Readings",
    "SampleSink",
]

Field = float | int | bool | str


class Reading(NamedTuple):
    """The newest value of a channel and when it came, by the gateway's monotonic clock."""

    value: float
    mono_ns: int


class Outcome(NamedTuple):
    """How an act ended, in the robot's own words where it gave any."""

    phase: CommandPhase
    message: str = ""


class SampleSink(Protocol):
    """Takes samples from an adapter.

    ``put`` may be called from any thread, never blocks and never raises. Samples of one call
    keep their order; calls of one thread keep theirs. What is put gets a sequence number and is
    lost only as a recorded gap.
    """

    def put(self, columns: Columns) -> None:
        """Take samples whose channels index `Site.channels`."""
        ...


class PictureSink(Protocol):
    """Takes pictures from an adapter; any thread; newest wins, so a picture may be dropped."""

    def offer(self, picture: Picture) -> None:
        """Take one picture in place of one of the same stream that still waits."""
        ...


class EventSink(Protocol):
    """Takes what is worth writing down; any thread; never blocks."""

    def tell(self, kind: str, message: str, *, device: str = "", good: bool = False) -> None:
        """Write one thing down. Callers say a loss once and a recovery once."""
        ...


class Readings(Protocol):
    """Gives the newest reading of the channels that safety depends on.

    Readings are taken before rate limit and deadband, and no later than the adapter's pacing
    (about 10 ms) after the robot's message came.
    """

    def latest(self, address: str) -> Reading | None:
        """Give the newest reading of a channel, or none if there never was one."""
        ...


class CommandTarget(Protocol):
    """The robot as something that can be told what to do.

    ``drive`` and ``stop`` may be called from the event loop: they do not block, do not queue
    (only the newest counts) and do not raise while the adapter is away (there is nobody to tell).
    """

    def drive(self, device: str, linear: float, angular: float) -> None:
        """Publish a velocity (m/s, rad/s) at once."""
        ...

    def stop(self, device: str, *, stopped: bool) -> None:
        """Publish on the device's STOP topic, if it has one."""
        ...

    def act(
        self, device: str, command: str, fields: dict[str, Field], done: Callable[[Outcome], None]
    ) -> None:
        """Begin a one-shot command with its request fields by path.

        ``done`` is called at most once, from any thread. An act that cannot begin is ``refused``;
        after that point an act without an answer is simply never done (the caller keeps time).
        """
        ...


class Adapter(CommandTarget, Readings, Protocol):
    """Speaks one robot protocol for as long as it runs.

    ``run`` returns only when cancelled, and has released everything then. It raises
    `AdapterLost` when the robot's side cannot be reached; the caller may run it again.
    """

    async def run(self) -> None:
        """Read the robot until cancelled."""
        ...

    def watch(self, streams: Collection[str]) -> None:
        """Take pictures of these streams (``device/stream``) and of no others."""
        ...

    def reconnect(self, device: str, done: Callable[[Outcome], None]) -> None:
        """Connect anew to all that belongs to a device, but for driving and STOP.

        ``done`` is called once, from any thread, within some seconds: *succeeded* when all of it
        is there, else *failed* with what is not.
        """
        ...
