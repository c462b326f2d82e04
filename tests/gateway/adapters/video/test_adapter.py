"""Cameras without ROS, against a network camera that speaks RTSP."""

from __future__ import annotations

import asyncio
import socket
import ssl
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from patience import PATIENCE_S

pytest.importorskip("av")

from talaia.clock import SystemClock
from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.adapters.video.adapter import VideoAdapter, address_of
from talaia.gateway.legacy.self_signed import self_signed
from talaia.gateway.ports import AdapterContext
from talaia.model.checks.site_checks import raise_first
from talaia.model.connection import VideoConnection
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import PictureForm

from ...video.scenes import psnr, scene
from ...video.test_camera import Hall, played
from .rtsp_camera import RtspCamera

SITE = """\
talaia: 1
site: yard
name: Yard
connections:
  cameras: {kind: video%s}
devices:
  gate:
    name: Gate
    streams:
      front: {name: Front, source: {%s}}
"""


class Told:
    """An `EventSink` and a `AdapterStatus`."""

    def __init__(self) -> None:
        """Have heard nothing."""
        self.events: list[tuple[str, str]] = []

    def report_event(self, kind: str, message: str, **_: object) -> None:
        self.events.append((kind, message))

    def up(self) -> None:
        self.events.append(("up", ""))

    def device(self, device: str, *, there: bool, why: str = "") -> None:
        pass


async def until(condition: Callable[[], object], within: float = PATIENCE_S) -> None:
    deadline = time.monotonic() + within
    while not condition():
        assert time.monotonic() < deadline
        await asyncio.sleep(0.01)


@asynccontextmanager
async def watched(
    source: str, folder: Path, more: str = ", here: true"
) -> AsyncIterator[tuple[Hall, Told, VideoAdapter]]:
    site = raise_first(load_site(SITE % (more, source)))
    hall, told = Hall(PictureForm.H264), Told()
    outlets = AdapterContext(SystemClock(), None, hall, told, folder)  # type: ignore[arg-type]
    video = VideoAdapter(scopes_of(site)[0], outlets, told)  # type: ignore[arg-type]
    running = asyncio.create_task(video.run())
    try:
        yield hall, told, video
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


FILM = [scene(320, 240)] * 10


async def test_a_network_camera_is_read_only_while_somebody_looks(tmp_path: Path) -> None:
    camera = RtspCamera(FILM)
    async with watched(f"url: 'rtsp://127.0.0.1:{camera.port}/x'", tmp_path) as (hall, _, video):
        await asyncio.sleep(0)
        assert camera.clients == 0
        video.watch(["gate/front"])
        await until(lambda: len(hall.got) >= 5)
        video.watch([])
        assert psnr(played(hall.got)[-1], scene(320, 240)) > 30
        await until(lambda: not video._cameras)
    camera.close()


async def test_a_camera_that_is_lost_says_so_once_and_comes_back(tmp_path: Path) -> None:
    camera = RtspCamera(FILM)
    async with watched(f"url: 'rtsp://127.0.0.1:{camera.port}/x'", tmp_path) as (hall, told, video):
        video.watch(["gate/front"])
        await until(lambda: hall.got)
        camera.drop()
        await until(lambda: hall.troubles)
        before = len(hall.got)
        await until(lambda: len(hall.got) > before + 3)
    kinds = [kind for kind, _ in told.events]
    assert kinds.count("camera") == 1
    assert kinds.count("camera back") == 1
    camera.close()


async def test_a_camera_with_a_password_has_it_from_a_file_and_nobody_is_told_it(
    tmp_path: Path,
) -> None:
    (tmp_path / "word").write_text("s3cr:t/@\n")
    camera = RtspCamera(FILM, "viewer:s3cr:t/@")
    more = ", here: true, user: viewer, password_file: word"
    url = f"url: 'rtsp://127.0.0.1:{camera.port}/x'"
    async with watched(url, tmp_path, more) as (hall, told, video):
        video.watch(["gate/front"])
        await until(lambda: hall.got)
        camera.close()
        await until(lambda: hall.troubles)
    assert "s3cr" not in repr((told.events, hall.troubles))


async def test_a_camera_whose_line_is_encrypted_is_read(tmp_path: Path) -> None:
    certificate, key = self_signed()
    (tmp_path / "both.pem").write_bytes(certificate + key)
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    tls.load_cert_chain(tmp_path / "both.pem")
    camera = RtspCamera(FILM, tls=tls)
    async with watched(f"url: 'rtsps://127.0.0.1:{camera.port}/x'", tmp_path) as (hall, _, video):
        video.watch(["gate/front"])
        await until(lambda: len(hall.got) >= 5)
    camera.close()


async def test_a_camera_that_sends_by_udp_gets_our_packets_and_nobody_it_names(
    tmp_path: Path,
) -> None:
    named = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    named.settimeout(0)
    camera = RtspCamera(FILM, source="127.0.0.9")
    named.bind(("127.0.0.9", camera.lossy.getsockname()[1]))
    camera.lossy.settimeout(0)
    url = f"url: 'rtsp://127.0.0.1:{camera.port}/x'"
    async with watched(url, tmp_path, ", here: true, udp: true") as (hall, _, video):
        video.watch(["gate/front"])
        await until(lambda: len(hall.got) >= 5)
        assert camera.lossy.recv(4096)
        with pytest.raises(BlockingIOError):
            named.recv(4096)
    camera.close()
    named.close()


async def test_what_is_no_camera_is_told_on_the_tile_and_nothing_falls_over(tmp_path: Path) -> None:
    async with watched("file: /dev/video250", tmp_path) as (hall, told, video):
        video.watch(["gate/front"])
        await until(lambda: len(hall.troubles) > 1)
        assert "/dev/video250" in hall.troubles[0]
        assert [kind for kind, _ in told.events].count("camera") == 1


async def test_a_camera_where_none_may_be_is_told_on_the_tile_with_the_key_to_set(
    tmp_path: Path,
) -> None:
    camera = RtspCamera(FILM)
    url = f"url: 'rtsp://localhost:{camera.port}/x'"
    async with watched(url, tmp_path, "") as (hall, _, video):
        video.watch(["gate/front"])
        await until(lambda: hall.troubles)
    assert "this computer itself" in hall.troubles[0]
    assert "here: true" in hall.troubles[0]
    assert camera.clients == 0
    camera.close()


@pytest.mark.parametrize(
    "source",
    [
        "url: 'file:///etc/passwd'",
        "url: 'http://169.254.169.254/latest'",
        "url: 'rtsp://me:word@camera/x'",
        "url: 'exec:rm'",
        "url: 'rtsp://127.0.0.1/x'",
        "url: 'rtsp://169.254.169.254/x'",
        "url: 'rtsp://[::ffff:127.0.0.1]/x'",
        "file: /etc/passwd",
        "file: /dev/../etc/passwd",
        "file: '/dev/video0 -y'",
        "url: 'rtsp://camera/x', file: /dev/video0",
        "topic: /images, type: sensor_msgs/msg/Image",
    ],
)
def test_nothing_but_a_camera_s_address_stands_in_a_description(source: str) -> None:
    with pytest.raises(DescriptionError):
        raise_first(load_site(SITE % ("", source)))


def test_an_address_gets_its_user_and_password_quoted(tmp_path: Path) -> None:
    (tmp_path / "w").write_text("a/b@c:d\n")
    settings = VideoConnection(user="me@home", password_file="w")  # noqa: S106 - a file
    assert (
        address_of("rtsp://cam:554/x?y=1", settings, tmp_path)
        == "rtsp://me%40home:a%2Fb%40c%3Ad@cam:554/x?y=1"
    )
