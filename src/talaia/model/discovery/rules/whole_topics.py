"""Topics that are one thing, and not numbers: a log, a path, a map. Pure."""

from __future__ import annotations

__all__ = ["LEVELS", "MODELS", "whole_of"]

# What a message of a type is, in words. Their points and cells are no signals: they say something
# only together.
_WHOLES = {
    "bond/msg/Status": "a heartbeat between the robot's own nodes",
    "control_msgs/msg/DynamicJointState": "joints as their controllers see them",
    "control_msgs/msg/JointTrajectoryControllerState": "the inside of a controller of joints",
    "nav_msgs/msg/MapMetaData": "the size of a map",
    "nav2_msgs/msg/BehaviorTreeLog": "a log of the robot's behaviours",
    "nav2_msgs/msg/Costmap": "a map",
    "nav2_msgs/msg/VoxelGrid": "a map",
    "sensor_msgs/msg/CameraInfo": "a camera's calibration",
    "sensor_msgs/msg/Joy": "a joystick of the robot's own",
    "sensor_msgs/msg/JoyFeedback": "a joystick of the robot's own",
    "theora_image_transport/msg/Packet": "a film of a camera",
    "geometry_msgs/msg/PolygonStamped": "a polygon",
    "geometry_msgs/msg/PoseArray": "a cloud of poses",
    "map_msgs/msg/OccupancyGridUpdate": "a part of a map",
    "nav_msgs/msg/GridCells": "a map",
    "nav_msgs/msg/OccupancyGrid": "a map",
    "nav_msgs/msg/Path": "a path",
    "octomap_msgs/msg/Octomap": "a map",
    "rcl_interfaces/msg/Log": "a log",
    "rosgraph_msgs/msg/Clock": "a clock",
    "sensor_msgs/msg/LaserScan": "a laser scan",
    "sensor_msgs/msg/MultiEchoLaserScan": "a laser scan",
    "sensor_msgs/msg/PointCloud": "a point cloud",
    "sensor_msgs/msg/PointCloud2": "a point cloud",
    "tf2_msgs/msg/TFMessage": "transforms",
    "trajectory_msgs/msg/JointTrajectory": "a trajectory",
    "trajectory_msgs/msg/MultiDOFJointTrajectory": "a trajectory",
    "visualization_msgs/msg/ImageMarker": "markers",
    "visualization_msgs/msg/InteractiveMarkerFeedback": "markers",
    "visualization_msgs/msg/InteractiveMarkerInit": "markers",
    "visualization_msgs/msg/InteractiveMarkerUpdate": "markers",
    "visualization_msgs/msg/Marker": "markers",
    "visualization_msgs/msg/MarkerArray": "markers",
}
# diagnostic_msgs/msg/DiagnosticStatus: what its levels 0 to 3 mean.
LEVELS = ("OK", "Warning", "Error", "Stale")


# Texts that are the robot's model, by the last part of their topic.
MODELS = ("robot_description", "robot_description_semantic", "urdf", "srdf")


def whole_of(type_name: str) -> str:
    """Say what a message of ``package/msg/Name`` is as a whole; empty of one that holds values."""
    return _WHOLES.get(type_name, "")
