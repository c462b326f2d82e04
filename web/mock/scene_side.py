"""What the made-up vehicle's topics tell a scene: a room, its map, a scan and where it is."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from rosbags.typesys import Stores, get_typestore

from talaia.sim.vehicle.description.urdf import ROBOT_DESCRIPTION
from talaia.wire import browser as wire
from talaia.wire.browser import TOPIC_TO_BROWSER

if TYPE_CHECKING:
    from world import World

STORE = get_typestore(Stores.LATEST)
TYPES = STORE.types
KINDS = {
    "/odom": "nav_msgs/msg/Odometry",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/robot_description": "std_msgs/msg/String",
}
LATCHED = ("/map", "/robot_description")
# Half of the room (m), and of a cell of its map.
HALF_X, HALF_Y, CELL = 4.0, 3.0, 0.1
LIDAR_AT = 0.19


def header(frame: str, now: float) -> object:
    """Give a stamp and a frame."""
    stamp = TYPES["builtin_interfaces/msg/Time"](int(now), int(now % 1 * 1e9))
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def pose(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> object:
    """Give a place with a heading."""
    return TYPES["geometry_msgs/msg/Pose"](
        position=TYPES["geometry_msgs/msg/Point"](x, y, z),
        orientation=TYPES["geometry_msgs/msg/Quaternion"](
            0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)
        ),
    )


def ranges(world: World) -> np.ndarray:
    """Measure to the walls, in each degree around."""
    angles = world.yaw + np.radians(np.arange(360))
    with np.errstate(divide="ignore"):
        across = (np.copysign(HALF_X, np.cos(angles)) - world.x) / np.cos(angles)
        along = (np.copysign(HALF_Y, np.sin(angles)) - world.y) / np.sin(angles)
    return np.minimum(np.abs(across), np.abs(along)).astype(np.float32)


def message(world: World, topic: str, now: float) -> object:
    """Give what a topic says now."""
    kind = TYPES[KINDS[topic]]
    if topic == "/robot_description":
        return kind(data=ROBOT_DESCRIPTION)
    if topic == "/odom":
        still = TYPES["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
        return kind(
            header=header("odom", now), child_frame_id="base_link",
            pose=TYPES["geometry_msgs/msg/PoseWithCovariance"](
                pose=pose(world.x, world.y, yaw=world.yaw), covariance=np.zeros(36)
            ),
            twist=TYPES["geometry_msgs/msg/TwistWithCovariance"](
                twist=TYPES["geometry_msgs/msg/Twist"](linear=still, angular=still),
                covariance=np.zeros(36),
            ),
        )  # fmt: skip
    if topic == "/scan":
        step = math.radians(1)
        return kind(
            header=header("base_scan", now), angle_min=0.0, angle_max=359 * step,
            angle_increment=step, time_increment=0.0, scan_time=0.1, range_min=0.1, range_max=12.0,
            ranges=ranges(world), intensities=np.zeros(0, np.float32),
        )  # fmt: skip
    cells = np.full((round(2 * HALF_Y / CELL) + 2, round(2 * HALF_X / CELL) + 2), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    info = TYPES["nav_msgs/msg/MapMetaData"](
        map_load_time=header("", now).stamp, resolution=CELL, width=cells.shape[1],
        height=cells.shape[0], origin=pose(-HALF_X - CELL, -HALF_Y - CELL),
    )  # fmt: skip
    return kind(header=header("odom", now), info=info, data=cells.reshape(-1))


async def follow(socket: WebSocket, world: World, topic: str) -> None:
    """Send a topic's messages as bytes, five times a second; what is latched once."""
    known, seq = topic in KINDS, 0
    first = wire.TopicUpdate(listed=known, type=KINDS.get(topic, ""), latched=topic in LATCHED)
    await socket.send_bytes(TOPIC_TO_BROWSER.encode(first))
    while known:
        if world.online:
            seq, now = seq + 1, time.time()
            data = bytes(STORE.serialize_cdr(message(world, topic, now), KINDS[topic]))
            said = wire.TopicBytes(
                number=seq, seq=seq, time_us=int(now * 1e6), encoding="cdr", data=data
            )
            await socket.send_bytes(TOPIC_TO_BROWSER.encode(said))
            if topic in LATCHED:
                return
        await asyncio.sleep(0.2)


def scene_router(world: World) -> APIRouter:
    """Give the list of topics, and the socket of one."""
    routes = APIRouter()

    @routes.get("/api/sites/{name}/topics")
    async def topics(name: str) -> dict[str, Any]:
        rows = [
            {
                "topic": topic, "type": kind, "latched": topic in LATCHED, "max_rate": 0.0,
                "problem": "", "described": True, "right": "view", "device": "", "rate": 5.0,
            }
            for topic, kind in KINDS.items()
        ]  # fmt: skip
        mine = name == world.site.site
        return {"online": world.online and mine, "topics": rows if mine else []}

    @routes.websocket("/ws/topic")
    async def one_topic(socket: WebSocket, topic: str = "") -> None:
        await socket.accept()
        sender = asyncio.create_task(follow(socket, world, topic))
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                # That something was shown: this mock sends slowly enough not to wait for it.
                await socket.receive_bytes()
        sender.cancel()

    return routes
