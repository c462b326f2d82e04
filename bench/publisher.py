"""A ROS 2 peer for the benchmarks: Float64 topics whose values are the moment of publication.

    python bench/publisher.py TOPICS RATE SECONDS [--camera] [--listen FILE]

Each value is the wall time of its publication in µs, so that whoever sees it knows its age. With
``--listen`` every ``/cmd_vel`` that arrives is written to FILE with the wall time of its arrival.
"""

from __future__ import annotations

import argparse
import array
import math
import sys
import threading
import time
from pathlib import Path

import numpy as np
import rclpy
import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded
from geometry_msgs.msg import Twist
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CompressedImage, Image, PointCloud2
from std_msgs.msg import Float64

import talaia.sim


def main() -> int:
    """Publish at a steady rate, spread over the period, until the time is up."""
    parser = argparse.ArgumentParser()
    parser.add_argument("topics", type=int)
    parser.add_argument("rate", type=float)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--camera", action="store_true")
    parser.add_argument("--cameras", type=int, default=0, help="numbered ones, 10 pictures/s each")
    parser.add_argument("--film", type=int, default=0, help="a moving scene at 30 Hz; its noise")
    parser.add_argument("--films", type=int, default=0, help="so many such cameras, numbered")
    parser.add_argument("--size", default="640x480", help="of the films of --films")
    parser.add_argument("--compressed", action="store_true", help="--films as JPEG")
    parser.add_argument("--clouds", type=float, default=0, help="1 MB each, so many a second")
    parser.add_argument("--waves", action="store_true", help="values that swing, as a sensor's")
    parser.add_argument("--listen", type=Path)
    options = parser.parse_args()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("bench_publisher")
    quality = QoSProfile(depth=100)
    publishers = [
        node.create_publisher(Float64, f"/bench/s{each}", quality) for each in range(options.topics)
    ]
    camera = node.create_publisher(Image, "/bench/image", QoSProfile(depth=1))
    numbered = [
        node.create_publisher(Image, f"/bench/image{each}", QoSProfile(depth=1))
        for each in range(options.cameras)
    ]
    if options.listen:
        listen(node, options.listen)
    if options.clouds:
        publish_clouds(node, options.clouds)
    if options.films:
        publish_films(node, options.films, options.size, compressed=options.compressed)
    print("ready", flush=True)
    message = Float64()
    picture = Image(width=640, height=480, encoding="rgb8", step=1920)
    picture.data = array.array("B", bytes(640 * 480 * 3))
    film = film_of(options.film) if options.film else []
    until = time.monotonic() + options.seconds
    step = 1 / (options.rate * options.topics) if options.topics else 1.0
    if film:
        step = 1 / 120
    turn, due = 0, time.monotonic()
    frame_due = due
    while due < until:
        due += step
        wait = due - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        if publishers:
            now = time.time()
            message.data = (
                10 * math.sin(now / 5 + turn % options.topics) if options.waves else now * 1e6
            )
            publishers[turn % options.topics].publish(message)
            turn += 1
        if film and time.monotonic() >= frame_due:
            frame_due += 1 / 30
            camera.publish(film[round(frame_due * 30) % len(film)])
        if options.camera and time.monotonic() >= frame_due:
            frame_due += 1 / 30
            camera.publish(picture)
        if numbered and time.monotonic() >= frame_due:
            frame_due += 0.1
            for each in numbered:
                each.publish(picture)
    return 0


def film_of(noise: int = 4, width: int = 640, height: int = 480, pictures: int = 60) -> list[Image]:
    """Pan to and fro over a photograph, with a camera's noise (of 255): two seconds of 640x480."""
    from PIL import Image as Pictures

    source = Path(talaia.sim.__file__).parent / "vehicle" / "pictures" / "coffee.jpg"
    with Pictures.open(source) as opened:
        whole = opened.convert("RGB").resize((width * 3 // 2, height * 4 // 3))
    wide = np.asarray(whole, np.int16)
    chance = np.random.default_rng(1)
    film = []
    for each in range(pictures):
        pans = (np.sin(turn * 2 * np.pi * each / pictures) for turn in (1, 2))
        left, top = (round(height / 6 * (1 + pan)) for pan in pans)
        view = wide[top : top + height, left : left + width] + chance.integers(
            -noise, noise + 1, (height, width, 3), np.int16
        )
        message = Image(width=width, height=height, encoding="rgb8", step=3 * width)
        message.data = array.array("B", np.clip(view, 0, 255).astype(np.uint8).tobytes())
        film.append(message)
    return film


def publish_films(node: rclpy.node.Node, count: int, size: str, *, compressed: bool) -> None:
    """Publish such a film for each of some cameras, 30 pictures a second of each, evenly spread."""
    width, height = map(int, size.split("x"))
    # Half a second of the largest: what is kept is to fit into memory.
    film: list[Image | CompressedImage] = [*film_of(4, width, height, 60 if height < 1000 else 16)]
    if compressed:
        film = [jpeg_of(each) for each in film]
    kind = CompressedImage if compressed else Image
    publishers = [
        node.create_publisher(kind, f"/bench/image{each}", QoSProfile(depth=1))
        for each in range(count)
    ]

    def publish() -> None:
        due = time.monotonic()
        for turn in range(10**9):
            due += 1 / 30 / count
            wait = due - time.monotonic()
            if wait > 0:
                time.sleep(wait)
            elif wait < -1:
                # As a camera whose computer is too slow: what is late is left out.
                due = time.monotonic()
            publishers[turn % count].publish(film[turn // count % len(film)])

    threading.Thread(target=publish, daemon=True).start()


def jpeg_of(picture: Image) -> CompressedImage:
    """Give a picture as a camera does that compresses."""
    import simplejpeg

    pixels = np.frombuffer(picture.data, np.uint8).reshape(picture.height, picture.width, 3)
    message = CompressedImage(format="jpeg")
    message.data = array.array("B", simplejpeg.encode_jpeg(pixels, 80, "RGB", "420"))
    return message


def publish_clouds(node: rclpy.node.Node, rate: float) -> None:
    """Publish a point cloud of 1 MB at a rate, stamped with the moment of its publication."""
    publisher = node.create_publisher(PointCloud2, "/bench/cloud", QoSProfile(depth=10))
    message = PointCloud2(height=1, width=62_500, point_step=16, row_step=1_000_000, is_dense=True)
    message.data = array.array("B", bytes(1_000_000))

    def publish() -> None:
        due = time.monotonic()
        while True:
            due += 1 / rate
            time.sleep(max(0.0, due - time.monotonic()))
            sec, nanosec = divmod(time.time_ns(), 10**9)
            message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
            publisher.publish(message)

    threading.Thread(target=publish, daemon=True).start()


def listen(node: rclpy.node.Node, target: Path) -> None:
    """Write each driving message with the moment it came."""
    log = target.open("w", buffering=1)

    def write(message: Twist) -> None:
        log.write(f"{time.time() * 1e6:.0f} {message.linear.x:.4f} {message.angular.z:.4f}\n")

    node.create_subscription(Twist, "/cmd_vel", write, QoSProfile(depth=10))
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        while True:
            executor.spin_once(timeout_sec=1.0)

    threading.Thread(target=spin, daemon=True).start()


if __name__ == "__main__":
    sys.exit(main())
