"""Which raw topics a generated description opens to those who may view the site."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.topics import TopicRight, TopicRule

if TYPE_CHECKING:
    from talaia.model.discovery.probe_report import Found

__all__ = ["topics_to_open"]

# What a 3D view or a map is made of: it tells of the robot what its signals and cameras tell, too.
_TYPES = frozenset(
    {
        "tf2_msgs/msg/TFMessage",
        "sensor_msgs/msg/LaserScan",
        "nav_msgs/msg/OccupancyGrid",
        "map_msgs/msg/OccupancyGridUpdate",
        "nav_msgs/msg/Odometry",
        "sensor_msgs/msg/JointState",
        "visualization_msgs/msg/Marker",
        "visualization_msgs/msg/MarkerArray",
        "geometry_msgs/msg/PoseArray",
        "nav_msgs/msg/Path",
        "sensor_msgs/msg/PointCloud2",
        "diagnostic_msgs/msg/DiagnosticArray",
    }
)
# They are often there only while something moves or is wrong.
_ALWAYS = ("/tf", "/tf_static", "/diagnostics", "/robot_description")


def topics_to_open(found: Found) -> tuple[TopicRule, ...]:
    """Open transforms, scans, maps, paths, clouds and diagnostics, where topics can be tapped."""
    if found.protocol not in {"ros1", "ros2", "rosbridge"}:
        return ()
    seen = sorted(topic.topic for topic in found.topics if topic.type in _TYPES)
    return tuple(
        TopicRule(pattern=topic, right=TopicRight.VIEW)
        for topic in dict.fromkeys((*_ALWAYS, *seen))
    )
