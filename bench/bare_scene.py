"""The yardstick of the scene: a page of three.js alone, fed by rclpy over a plain socket.

    python bench/bare_scene.py PORT WIDTH HEIGHT LINKS [--cloud]

It draws what `scene_robot.py` publishes, as large as Talaia's canvas is: with no rights, no TLS, no
frames to look up and nothing between ROS and the page but this process.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import mimetypes
import sys
from pathlib import Path

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
import websockets
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from scene_robot import transforms_class
from sensor_msgs.msg import LaserScan, PointCloud2
from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

HERE = Path(__file__).resolve().parent
THREE = HERE.parent / "web" / "node_modules" / "three"
# Each message begins with its topic's number; four bytes, so that numbers in it stay aligned.
TOPICS = {"/bench/tf": (0, transforms_class()), "/bench/scan": (1, LaserScan)}
CLOUD = {"/bench/cloud": (2, PointCloud2)}
MOST_WAITING = 4_000_000


class Relay:
    """Hands what ROS says to every page that is there."""

    def __init__(self) -> None:
        """Begin with no page."""
        self._pages: set[ServerConnection] = set()

    async def serve_page(self, page: ServerConnection) -> None:
        """Feed one page until it goes."""
        self._pages.add(page)
        try:
            await page.wait_closed()
        finally:
            self._pages.discard(page)

    def hand_on(self, number: int, raw: bytes) -> None:
        """Send a message to all; one that does not read misses some."""
        frame = number.to_bytes(4, "little") + raw
        for page in self._pages:
            if page.transport.get_write_buffer_size() < MOST_WAITING:
                asyncio.ensure_future(self._send(page, frame))  # noqa: RUF006 - it ends by itself

    async def _send(self, page: ServerConnection, frame: bytes) -> None:
        with contextlib.suppress(websockets.ConnectionClosed):
            await page.send(frame)


def static_files(look: str) -> object:
    """Give what answers requests for the page and for three.js itself."""

    def answer(_page: ServerConnection, request: Request) -> Response | None:
        if "Upgrade" in request.headers:
            return None
        path = request.path.partition("?")[0]
        file = HERE / "bare_scene.html" if path == "/" else (THREE / path.lstrip("/")).resolve()
        ours = file.is_relative_to(HERE) or file.is_relative_to(THREE.resolve())
        if ours and file.is_file():
            body = file.read_bytes()
            if path == "/":
                body = body.replace(b"LOOK", look.encode())
            kind = mimetypes.guess_type(file.name)[0] or "text/javascript"
            headers = Headers({"Content-Type": kind, "Content-Length": str(len(body))})
            return Response(200, "OK", headers, body)
        return Response(404, "Not Found", Headers({"Content-Length": "0"}), b"")

    return answer


async def run_server(port: int, look: str, *, cloud: bool) -> None:
    """Serve the page, and spin ROS in a thread of its own."""
    relay, loop = Relay(), asyncio.get_running_loop()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("bare_scene", enable_rosout=False)
    for topic, (number, kind) in {**TOPICS, **(CLOUD if cloud else {})}.items():

        def heard(raw: bytes, number: int = number) -> None:
            loop.call_soon_threadsafe(relay.hand_on, number, raw)

        node.create_subscription(kind, topic, heard, QoSProfile(depth=10), raw=True)
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        while True:
            executor.spin_once(timeout_sec=1.0)

    async with serve(
        relay.serve_page, "127.0.0.1", port, process_request=static_files(look),
        compression=None, max_size=None, ping_interval=None,
    ):  # type: ignore[arg-type]  # fmt: skip
        print("ready", flush=True)
        await asyncio.to_thread(spin)


def main() -> int:
    """Serve until one is ended."""
    parser = argparse.ArgumentParser()
    for name in ("port", "width", "height", "links"):
        parser.add_argument(name, type=int)
    parser.add_argument("--cloud", action="store_true")
    asked = parser.parse_args()
    look = f"{{ width: {asked.width}, height: {asked.height}, links: {asked.links} }}"
    asyncio.run(run_server(asked.port, look, cloud=asked.cloud))
    return 0


if __name__ == "__main__":
    sys.exit(main())
