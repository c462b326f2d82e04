"""The board of a robot's topics that are one thing: scene, diagnostics, log, parameters. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.boards.board import Board, BoardTile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.discovery.probe_report import Found
    from talaia.model.site import Device

__all__ = ["robot_boards"]

_IN_SCENE = (
    "tf2_msgs/msg/TFMessage",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/PointCloud2",
    "nav_msgs/msg/OccupancyGrid",
    "nav_msgs/msg/Path",
    "visualization_msgs/msg/Marker",
    "visualization_msgs/msg/MarkerArray",
    "geometry_msgs/msg/PoseArray",
)
_DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"


def robot_boards(found: Found, devices: Mapping[str, Device]) -> dict[str, Board]:
    """Give the board *Robot* with a tile for each kind of thing that the robot has."""
    # Raw topics come through a gateway that is a ROS node, or a rosbridge.
    if found.protocol not in ("ros1", "ros2", "rosbridge"):
        return {}
    # A tile of what nobody publishes would stay empty.
    said = [topic for topic in found.topics if topic.publishers]
    tiles: list[BoardTile] = []
    if any(topic.type in _IN_SCENE for topic in said):
        tiles.append(BoardTile(type="scene"))
    if any(device.streams for device in devices.values()):
        tiles.append(BoardTile(type="cameras"))
    diagnostics = [topic.topic for topic in said if topic.type == _DIAGNOSTICS]
    if diagnostics:
        # The sorted ones, where somebody sorts them.
        best = next((one for one in diagnostics if one.endswith("_agg")), diagnostics[0])
        tiles.append(BoardTile(type="diagnostics", settings={"topic": best}))
    if not tiles:
        # Its devices have a board of their own already.
        return {}
    if any(node.parameters for node in found.nodes):
        tiles.append(BoardTile(type="parameters"))
    if any(node.lifecycle for node in found.nodes):
        tiles.append(BoardTile(type="lifecycle"))
    # Every node writes one, so it is always there.
    tiles.append(BoardTile(type="log"))
    return {"robot": Board(name="Robot", note="What the robot's topics show.", tiles=tuple(tiles))}
