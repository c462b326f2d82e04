"""Object detection: how many pictures a second it looks at, and what driving notices of it."""

from __future__ import annotations

import asyncio
import contextlib
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import clients
import link
import numpy as np
import psutil
import stack
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from talaia.cli.child_processes import ChildProcess, end_all, start_talaia
from talaia.sim import ros_domain
from talaia.wire import frames

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

CLASSES = "classes: [person, cup]"
# As fast as the film is.
DETECT = f"{{{CLASSES}, max_rate: 30}}"
# What looks while somebody drives; at 10 Hz where no rate is said.
WAYS = {
    "nothing": "",
    "gateway": f"{{{CLASSES}}}",
    "hub": f"{{at: hub, {CLASSES}}}",
    "gateway at 30 Hz": DETECT,
}


class Seen(NamedTuple):
    """How a gateway saw for a while.

    Attributes:
        ages_ms: of each picture when its boxes were at the hub.
        rate: pictures a second.
        detector: what its process took, in percent of a core.
        gateway: the same of the gateway's own.
        wanted: boxes with something on them; the film shows a cup.

    """

    ages_ms: np.ndarray
    rate: float
    detector: float
    gateway: float
    wanted: float


class Door:
    """As much of a hub as a gateway needs to tell boxes to: rates are not to be a hub's."""

    def __init__(self) -> None:
        """Begin with none."""
        self.boxes: list[tuple[float, frames.DetectedBoxes]] = []
        self._link: ServerConnection | None = None

    async def take(self, socket: ServerConnection) -> None:
        """Serve a connection of the gateway."""
        path = "" if socket.request is None else socket.request.path
        with contextlib.suppress(ConnectionClosed):
            if path.endswith("media"):
                async for data in socket:
                    message = frames.MEDIA_FROM_GATEWAY.decode(data)
                    if isinstance(message, frames.DetectedBoxes):
                        self.boxes.append((time.time() * 1e6, message))
                    elif isinstance(message, frames.Beat):
                        await socket.send(frames.MEDIA_FROM_HUB.encode(_reply(message)))
                return
            await socket.recv()
            welcome = frames.Welcome(takes=["seen"])
            await socket.send(frames.LINK_FROM_HUB.encode(welcome))
            watch = frames.StreamSubscription(streams=[], boxes=["base/front"])
            await socket.send(frames.LINK_FROM_HUB.encode(watch))
            async for data in socket:
                said = frames.LINK_FROM_GATEWAY.decode(data)
                if isinstance(said, frames.Beat):
                    await socket.send(frames.LINK_FROM_HUB.encode(_reply(said)))


def _reply(beat: frames.Beat) -> frames.BeatReply:
    return frames.BeatReply(n=beat.n, mono_us=beat.mono_us, peer_us=0)


async def seen(seconds: float = 20) -> Seen:
    """Let a gateway look at a film of 640 × 480 at 30 Hz from a ROS 2 node."""
    door = Door()
    async with serve(door.take, "127.0.0.1", 0, compression=None, max_size=None) as server:
        port = server.sockets[0].getsockname()[1]
        async with _gateway(port) as here, stack.publisher(here, 1, 20.0, "--film", "4"):
            while not door.boxes:
                await asyncio.sleep(0.05)
            await asyncio.sleep(2)
            (child,) = psutil.Process(here.gateway.process.pid).children()
            door.boxes.clear()
            began, before = time.monotonic(), child.cpu_times()
            gateway = await stack.cpu_percent(here.gateway, seconds)
            after, took = child.cpu_times(), time.monotonic() - began
    ages = np.array([(at - boxes.time_us) / 1000 for at, boxes in door.boxes])
    used = (after.user + after.system) - (before.user + before.system)
    things = sum(any(each.label == "cup" for each in boxes.things) for _, boxes in door.boxes)
    share = 100 * things / max(1, len(ages))
    return Seen(ages, len(ages) / took, 100 * used / took, gateway, share)


@contextlib.asynccontextmanager
async def _gateway(port: int) -> AsyncIterator[stack.Stack]:
    with tempfile.TemporaryDirectory(prefix="talaia-bench-") as name:
        folder = Path(name)
        world = ros_domain.reserve_domain().domain
        here = ros_domain.domain_environment(world)
        (folder / "key").write_text("nobody-asks-for-it")
        (folder / "site.yaml").write_text(stack.site_text(1, camera=True, detect=DETECT))
        words = [
            "gateway", str(folder / "site.yaml"), "--hub", f"ws://127.0.0.1:{port}",
            "--allow-plain", "--key-file", str(folder / "key"),
            "--data", str(folder / "gateway"), "--ros-domain", str(world),
        ]  # fmt: skip
        gateway: ChildProcess = await start_talaia("gateway", words, folder / "gateway.log", here)
        try:
            await gateway.wait_line("linked to", 30)
            yield stack.Stack(folder, port, gateway, gateway, here)
        finally:
            await end_all([gateway])


async def driven(rounds: int = 3, presses: int = 250) -> dict[str, np.ndarray]:
    """Drive by the picture of a camera, in turn without detection and with it at either place.

    Who drives looks at the camera in each: what its film costs is not what detection costs.

    Returns:
        for each of ``WAYS`` the times (ms).

    Raises:
        RuntimeError: nothing looked where something should have.

    """
    ages: dict[str, list[np.ndarray]] = {way: [] for way in WAYS}
    for _ in range(rounds):
        for way, detect in WAYS.items():
            async with stack.running(1, camera=True, detect=detect) as here:
                target = here.folder / "driven.txt"
                session = await clients.cookie(here)
                # As on a robot the camera is a process of its own, that holds up no driving.
                async with (
                    stack.publisher(here, 1, 20.0, "--listen", str(target)),
                    stack.publisher(here, 0, 20.0, "--film", "4"),
                    link.watching(here, session, "front"),
                ):
                    await asyncio.sleep(4)
                    ages[way].append(await link.driven(here, session, target, presses))
                    place = here.hub if way == "hub" else here.gateway
                    looking = psutil.Process(place.process.pid).children()
                    if bool(looking) != bool(detect):
                        raise RuntimeError(f"{way}: {len(looking)} detectors")
    return {way: np.concatenate(each) for way, each in ages.items()}
