"""Cameras without ROS, by PyAV: on the network (RTSP) or at this computer's USB (V4L2).

Each camera that somebody looks at is read on a thread of its own, which the codec leaves to others
while it works; one that fails is tried again, and its tile says why.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
from typing import TYPE_CHECKING, cast
from urllib.parse import quote, urlsplit, urlunsplit

import av
import numpy as np

from talaia.gateway.adapters.undriven_adapter import UndrivenAdapter
from talaia.gateway.adapters.video.relay import CameraRefused, CameraRelay
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import ChannelReading, CommandOutcome
from talaia.gateway.video.camera import PictureStream
from talaia.gateway.video.pixels import Pixels
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import VideoConnection, VideoSource, source_as
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator
    from pathlib import Path

    from av.container import InputContainer

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus, Field
    from talaia.model.site import Stream

__all__ = ["VideoAdapter", "address_of", "pixels_in"]

log = logging.getLogger(__name__)
# Opening may take so long, and so may a picture after the other (s).
OPEN_S, SILENT_S = 5.0, 3.0
AGAIN_S = 2.0
# What a camera may lead us to: no file, no other protocol.
_PROTOCOLS, _LOSSY_PROTOCOLS = "rtsp,tcp", "rtsp,tcp,rtp,udp"


class VideoAdapter(UndrivenAdapter):
    """An `Adapter` for cameras only."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be served and where pictures go."""
        assert isinstance(scope.connection, VideoConnection)  # noqa: S101 - the catalog has seen to it
        self._settings = scope.connection
        self._scope = scope
        self._status = status
        self._context = context
        self._cameras: dict[str, _Camera] = {}
        self._watched: frozenset[str] = frozenset()
        self._worker: PictureWorker | None = None

    async def run(self) -> None:
        """See `Adapter.run`."""
        self._worker = PictureWorker(
            self._context.pictures, self._context.clock, self._context.budget
        )
        self._worker.start()
        self._status.up()
        self._update_cameras()
        try:
            await asyncio.Event().wait()
        finally:
            worker, self._worker = self._worker, None
            for camera in self._cameras.values():
                camera.end_camera()
            self._cameras.clear()
            await asyncio.shield(asyncio.to_thread(worker.close))

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        self._watched = frozenset(streams)
        self._update_cameras()

    def _update_cameras(self) -> None:
        if self._worker is None:
            return
        for address in self._cameras.keys() - self._watched:
            self._cameras.pop(address).end_camera()
        for address in self._watched - self._cameras.keys():
            device, _, name = address.partition("/")
            described = self._scope.devices.get(device)
            stream = None if described is None else described.streams.get(name)
            if stream is not None:
                self._cameras[address] = _Camera(
                    address=address,
                    stream=stream,
                    settings=self._settings,
                    context=self._context,
                    worker=self._worker,
                )

    def latest(self, address: str) -> ChannelReading | None:
        """Have no signals."""
        return None

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Field],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """Refuse: a camera has no commands."""
        done(CommandOutcome(CommandPhase.REFUSED, "a camera has no commands"))
        return None

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Open the device's cameras anew."""
        for address in [camera for camera in self._cameras if camera.split("/", 1)[0] == device]:
            self._cameras.pop(address).end_camera()
        self._update_cameras()
        done(CommandOutcome(CommandPhase.SUCCEEDED))


class _Camera:
    """One camera that is read until `end_camera`."""

    def __init__(
        self,
        *,
        address: str,
        stream: Stream,
        settings: VideoConnection,
        context: AdapterContext,
        worker: PictureWorker,
    ) -> None:
        self._address = address
        self._source = source_as(stream.source, VideoSource)
        self._settings = settings
        self._context = context
        self._worker = worker
        self._taker = PictureStream(address, stream, _read_pixels, self._report_problem)
        self._ended = threading.Event()
        self._well = True
        threading.Thread(target=self._read_loop, name=f"talaia-{address}", daemon=True).start()

    def end_camera(self) -> None:
        """Read no more; what is under way ends by itself within seconds."""
        self._ended.set()

    def _report_problem(self, address: str, problem: str) -> None:
        self._context.events.report_event("camera", problem, device=address.split("/", 1)[0])

    def _read_loop(self) -> None:
        while not self._ended.is_set():
            try:
                with self._open_container() as container:
                    self._play_stream(container)
            except CameraRefused as error:
                self._handle_lost(str(error))
            except (av.FFmpegError, OSError, ValueError, FieldError) as error:
                # The codec's own words may repeat the address, with the password in it.
                self._handle_lost(str(error).split(":")[0])
            else:
                if not self._ended.is_set():
                    self._handle_lost("the camera has ended its stream")
            self._ended.wait(AGAIN_S)

    @contextlib.contextmanager
    def _open_container(self) -> Iterator[InputContainer]:
        source, timeout = self._source, (OPEN_S, SILENT_S)
        if source.file:
            with av.open(source.file, format="v4l2", timeout=timeout) as container:
                yield container
            return
        options = {
            "rtsp_transport": "udp" if self._settings.udp else "tcp",
            "fflags": "nobuffer",
            "probesize": "200000",
            "analyzeduration": "500000",
            "protocol_whitelist": _LOSSY_PROTOCOLS if self._settings.udp else _PROTOCOLS,
        }
        with CameraRelay(source.url, here=self._settings.here, timeout=OPEN_S) as relay:
            url = address_of(relay.url, self._settings, self._context.folder)
            try:
                with av.open(url, format="rtsp", options=options, timeout=timeout) as container:
                    yield container
            except av.FFmpegError:
                if relay.refusal is not None:
                    raise relay.refusal from None
                raise

    def _play_stream(self, container: InputContainer) -> None:
        if not container.streams.video:
            raise FieldError("", "there are no pictures in what it sends")
        video = container.streams.video[0]
        video.thread_type = "NONE"
        video.codec_context.thread_count = 1
        for frame in container.decode(video):
            if self._ended.is_set():
                return
            if not self._well:
                self._well = True
                self._context.events.report_event(
                    "camera back", self._address, device=self._address.split("/", 1)[0], good=True
                )
            self._worker.offer_raw(self._taker, frame)

    def _handle_lost(self, why: str) -> None:
        where = self._source.url or self._source.file
        said = f"{where}: {why}"
        if self._well:
            self._well = False
            log.warning("%s: %s", self._address, said)
            self._report_problem(self._address, said)
        self._context.pictures.trouble(self._address, f"{said}; trying again")


def address_of(url: str, settings: VideoConnection, folder: Path) -> str:
    """Give a camera's address with its user and password, which stand in a file.

    Raises:
        OSError: the file cannot be read.

    """
    if not settings.user:
        return url
    parts = urlsplit(url)
    user = quote(settings.user, safe="")
    if settings.password_file:
        word = (folder / settings.password_file).read_text().strip()
        user += f":{quote(word, safe='')}"
    return urlunsplit(parts._replace(netloc=f"{user}@{parts.netloc}"))


def pixels_in(frame: av.VideoFrame) -> Pixels:
    """Give a decoded frame as planes."""
    width, height = frame.width & ~1, frame.height & ~1
    planes = frame.reformat(width, height, "yuv420p").to_ndarray()
    return Pixels("I420", width, height, np.asarray(planes, np.uint8))


def _read_pixels(raw: object) -> object:
    return pixels_in(cast("av.VideoFrame", raw))
