"""The promises between the parts: what an adapter gives and what is asked of a robot.

Long, because each promise is told whole, and in one place.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.gateway.cores.shared_budget import SharedBudget
    from talaia.gateway.tap_ports import TapSink
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.model.detection import Blur
    from talaia.model.site import Device
    from talaia.objects.detection import Detection
    from talaia.wire.columns import Columns
    from talaia.wire.frames import CommandPhase, FromGateway, LogLine, PictureFrame

__all__ = [
    "Adapter",
    "AdapterContext",
    "AdapterStatus",
    "CameraFrame",
    "CameraFrames",
    "ChannelReading",
    "CommandOutcome",
    "CommandTarget",
    "ControlOutput",
    "EventSink",
    "FileSink",
    "Filming",
    "FrameSink",
    "LogSink",
    "PacedAdapter",
    "PictureSink",
    "RawSink",
    "ReadingSource",
    "SampleSink",
]

Field = float | int | bool | str


class ChannelReading(NamedTuple):
    """The newest value of a channel and when it was true, by the gateway's monotonic clock.

    Attributes:
        mono_ns: when it came; where its own stamp is read, when that advanced last.
        stamp_ns: its own stamp (ns since the epoch, by the robot's clock); 0 where none is read.
        arrived_ns: when it came, where its own stamp is read.
        numbers: of a position: all of it, of one message (`model.site.parts_of`).

    """

    value: float
    mono_ns: int
    stamp_ns: int = 0
    arrived_ns: int = 0
    numbers: tuple[float, ...] = ()


class CommandOutcome(NamedTuple):
    """How an act ended, or stands, in the robot's own words where it gave any.

    Attributes:
        phase: ``running`` as often as the robot says so, then one of the final ones, once.
        message: the robot's words.
        progress: 0 to 1, while running.

    """

    phase: CommandPhase
    message: str = ""
    progress: float = 0.0


class SampleSink(Protocol):
    """Takes samples from an adapter.

    ``put_samples`` may be called from any thread, never blocks and never raises. Samples of one
    call keep their order; calls of one thread keep theirs. What is put gets a sequence number and
    is lost only as a recorded gap.
    """

    def put_samples(self, columns: Columns) -> None:
        """Take samples whose channels index `Site.channels`."""
        ...


class Filming(Enum):
    """Whether a camera is filmed; ``ANEW``: the film needs a picture to begin with, told once."""

    NO = auto()
    ON = auto()
    ANEW = auto()


class PictureSink(Protocol):
    """Takes pictures from an adapter and says what is wanted of them; any thread; never blocks.

    Newest wins, so a picture may be dropped.
    """

    def asked(self, stream: str) -> Collection[str]:
        """Name the forms (`talaia.wire.frames.PictureForm`) that a stream is wanted in now."""
        ...

    def key_due(self, stream: str, form: str) -> bool:
        """Tell whether somebody needs a picture to begin with; told once."""
        ...

    def room(self) -> float:
        """Give the share of its usual bits that a picture may have (to 1); 0 for none now."""
        ...

    def offer_frame(
        self,
        stream: str,
        stamp: tuple[int, int, int],
        decode: Callable[[], NDArray[np.uint8] | None],
        blurred: Callable[[], NDArray[np.uint8] | None] | None = None,
    ) -> None:
        """Take a picture for those at the gateway: number, wall and monotonic time (µs), RGB.

        ``blurred`` gives what of it may leave the gateway, where that is less than all of it.
        """
        ...

    def find_private(self, blur: Blur, rgb: NDArray[np.uint8]) -> Sequence[Detection]:
        """Find on a picture what is to be blurred; this blocks, for seconds at the most.

        Raises:
            DetectorError: it could not be looked at.

        """
        ...

    def offer(self, picture: PictureFrame) -> None:
        """Take one encoded picture for the hub."""
        ...

    def filming(self, stream: str, time_us: int) -> Filming:
        """Tell whether a picture that came then (wall) is filmed here, whoever else looks at it."""
        ...

    def film(self, picture: PictureFrame) -> None:
        """Take the next encoded picture of a stream's film; none may be left out."""
        ...

    def trouble(self, stream: str, why: str) -> None:
        """Take why a stream cannot be shown now; said again while it lasts."""
        ...


class CameraFrame(NamedTuple):
    """One picture of a camera for a program that looks at it.

    Attributes:
        stream: the camera's address, ``device/stream``.
        seq: its number, which the picture that viewers get of it carries, too.
        time_us: when it came, by the gateway's wall clock (µs since the epoch, UTC).
        mono_us: the same by the gateway's monotonic clock (µs).
        rgb: rows, columns, 3 (uint8); shared with others who look: not to be written to. It is
            what the camera saw, and stays at the gateway.
        blurred: gives what of it may leave the gateway, or nothing where none of it may (blocks:
            not on the event loop); none where all may.

    """

    stream: str
    seq: int
    time_us: int
    mono_us: int
    rgb: NDArray[np.uint8]
    blurred: Callable[[], NDArray[np.uint8] | None] | None = None

    def may_leave(self) -> NDArray[np.uint8] | None:
        """Give what of it may leave the gateway; blocks."""
        return self.rgb if self.blurred is None else self.blurred()


class CameraFrames(Protocol):
    """Gives the newest picture of any camera as pixels. Any thread.

    A camera that is held is read whether or not a person looks at it, and costs no encoding.
    """

    def hold(self, stream: str) -> Callable[[], None]:
        """Have pictures of a stream (``device/stream``) from now on.

        Returns:
            What lets it rest again.

        """
        ...

    def arrived(self, stream: str, since_us: int = 0, wait_s: float = 0.0) -> int:
        """Tell whether a picture came, without reading it.

        Numbers of pictures begin anew when a camera is connected anew; its clock does not.

        Args:
            stream: see `hold`.
            since_us: after this moment of the gateway's monotonic clock (µs).
            wait_s: wait for one so long, if there is none (blocks: not on the event loop).

        Returns:
            The moment at which the newest came; 0 when there is none.

        """
        ...

    def newest(self, stream: str, after: int = 0, wait_s: float = 0.0) -> CameraFrame | None:
        """Give the newest picture of a stream that is held, made RGB on the caller's thread.

        Args:
            stream: see `hold`.
            after: only one with a higher number than this.
            wait_s: wait for one so long, if there is none (blocks: not on the event loop).

        Returns:
            None when there is none, or it cannot be read.

        """
        ...


class RawSink(Protocol):
    """Takes messages as they came, to record them; any thread; never blocks for long."""

    topics: frozenset[str]

    def offer(
        self,
        topic: str,
        type_name: str,
        data: bytes,
        time_ns: int,
        *,
        definition: str = "",
        encoding: str = "cdr",
    ) -> None:
        """Take one message of one of ``topics``, with the time at which it came (wall, ns).

        Args:
            topic: absolute.
            type_name: ``package/msg/Name``.
            data: CDR, or ROS 1's own form.
            time_ns: see above.
            definition: of the type, as its publisher tells it; empty for ROS 2 where the type's
                package is installed here.
            encoding: of ``data``: ``cdr`` or ``ros1``.

        """
        ...


class EventSink(Protocol):
    """Takes what is worth writing down; any thread; never blocks."""

    def report_event(
        self, kind: str, message: str, *, device: str = "", who: str = "", good: bool = False
    ) -> None:
        """Write one thing down. Callers say a loss once and a recovery once."""
        ...


class LogSink(Protocol):
    """Keeps lines of the robot's own log until the hub has them; any thread; never blocks."""

    def keep_line(self, line: LogLine) -> None:
        """Keep a line. Callers bound how many there are."""
        ...


@runtime_checkable
class PacedAdapter(Protocol):
    """An adapter that reads what came in turns, which are shorter while somebody looks."""

    def shorten_turns(self, turn_s: float) -> None:
        """Read what the robot says so often (s); `math.inf`: nobody looks; event loop."""
        ...


class ReadingSource(Protocol):
    """Gives the newest reading of the channels that safety depends on.

    Readings are taken before rate limit and deadband, and no later than the adapter's pacing
    (about 20 ms) after the robot's message came.
    """

    def latest(self, address: str) -> ChannelReading | None:
        """Give the newest reading of a channel, or none if there never was one."""
        ...


class AdapterStatus(Protocol):
    """Where an adapter says how its side stands. Any thread; never blocks."""

    def up(self) -> None:
        """Say that the robot's side is reached, in each `Adapter.run` once it is so.

        The loss is told by raising `AdapterLost`, and by nothing else.
        """
        ...

    def device(self, device: str, *, there: bool, why: str = "", sure: bool = True) -> None:
        """Say that one device does not answer, or does again, while the rest goes on.

        A page shows what it had to say as unknown at once, and does not wait for it to grow old.
        May be called as often as one likes: only changes are told. Of one that may only be slow
        it is not ``sure``: for interlocks its last values count until they are too old.
        """
        ...

    def found(self, devices: Mapping[str, Device]) -> None:
        """Tell of all devices found that the description does not name, by names for addresses.

        The gateway describes itself anew with them and begins again if there are new ones, so
        call it when all that is to be found has been.
        """
        ...


class AdapterContext(NamedTuple):
    """Where an adapter gives what it hears, and what it may use.

    Attributes:
        folder: where the description stands: relative paths in it begin there.
        domain: a ROS domain that overrides the description's.
        site: what people call the site.
        answers: where the commands of a process connection leave what they printed, by the
            signal's address; none where nobody asks for it.
        frames: takes pictures for the archive; none where nobody keeps them.
        files: takes pictures for the archive that come whole; none as with ``frames``.
        raw: takes messages as they came, to record them; none where nothing is recorded.
        taps: takes messages as they came for the hub; none where nobody hands them on.
        kept_log: takes lines of the robot's log; none where nobody keeps them.
        budget: what all pictures together may take of the cores; none gives each adapter its own.

    """

    clock: Clock
    samples: SampleSink
    pictures: PictureSink
    events: EventSink
    folder: Path
    domain: int | None = None
    answers: dict[str, str] | None = None
    frames: FrameSink | None = None
    files: FileSink | None = None
    site: str = ""
    raw: RawSink | None = None
    taps: TapSink | None = None
    kept_log: LogSink | None = None
    budget: SharedBudget | None = None


class FileSink(Protocol):
    """Takes pictures for the archive that come as whole FITS files."""

    def keep_file(self, device: str, read: Callable[[], bytes]) -> None:
        """Keep a file, unless it is one that came before. From any thread; returns at once.

        Args:
            device: the camera's, in the description.
            read: gives the file's bytes; called later, on another thread. What it raises as
                `FieldError` is the file's problem.

        """
        ...


class FrameSink(Protocol):
    """Takes one picture after the other, each in pieces, and none in memory whole."""

    async def begin(
        self, device: str, form: str, size: int, complete: Callable[[bytes], bytes]
    ) -> None:
        """Begin a picture.

        Args:
            device: the camera's, in the description.
            form: the file's ending, ``.fits`` or another; ``.z`` behind it is zlib.
            size: bytes that it will have in the end, as the camera says; 0 if it does not.
            complete: gives the whole header for the one that came. Called on the event loop.

        """
        ...

    async def write(self, data: bytes) -> None:
        """Take its next bytes."""
        ...

    async def end(self, problem: str) -> str:
        """End it; give what is wrong with it, or nothing when it is kept."""
        ...

    async def drop(self) -> None:
        """Forget a picture that will not end."""
        ...


class CommandTarget(Protocol):
    """The robot as something that can be told what to do.

    ``drive`` and ``stop`` may be called from the event loop: they do not block, do not queue
    (only the newest counts) and do not raise while the adapter is away (there is nobody to tell).
    """

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Publish a demand at once.

        ``key`` is the character instead, to a device that is driven by characters: each one is
        sent, in order.
        """
        ...

    def stop(self, device: str, *, stopped: bool) -> None:
        """Publish on the device's STOP topic, if it has one."""
        ...

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Field],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """Begin a one-shot command with its request fields by path.

        ``done`` is called from any thread: with ``running`` any number of times, and with a final
        phase at most once, last. An act that cannot begin is ``refused``; after that point an act
        without an answer is simply never done (the caller keeps time).

        Returns:
            What asks the robot to end it early, from any thread; none where that cannot be asked.

        """
        ...


class Adapter(CommandTarget, ReadingSource, Protocol):
    """Speaks one robot protocol for as long as it runs.

    ``run`` returns only when cancelled, and has released everything then. It raises
    `AdapterLost` when the robot's side cannot be reached; the caller may run it again. By then
    it has told *unknown* of every act that is under way, and has no `latest` any more.
    """

    async def run(self) -> None:
        """Read the robot until cancelled."""
        ...

    def watch(self, streams: Collection[str]) -> None:
        """Take pictures of these streams (``device/stream``) and of no others."""
        ...

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Connect anew to all that belongs to a device, but for driving and STOP.

        ``done`` is called once, from any thread, within some seconds: *succeeded* when all of it
        is there, else *failed* with what is not.
        """
        ...


class ControlOutput(Protocol):
    """What those who decide say: to the robot, to the hub, and to the record."""

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Publish a velocity, or the character that stands for it."""
        ...

    def stop(self, device: str, *, stopped: bool) -> None:
        """Publish on the STOP topic."""
        ...

    def send(self, message: FromGateway) -> None:
        """Send to the hub."""
        ...

    def record_event(self, kind: str, device: str, message: str, who: str, *, good: bool) -> None:
        """Write down."""
        ...
