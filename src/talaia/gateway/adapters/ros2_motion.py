"""Driving and STOP as ROS 2 publications. Called from the event loop: nothing here waits."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from talaia.gateway.adapters.ros2_requests import class_of, velocity_message
from talaia.gateway.errors import TypeMissing

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.share import Share

__all__ = ["Ros2Motion"]

log = logging.getLogger(__name__)
BOOL = "std_msgs/msg/Bool"


class Ros2Motion:
    """The publishers of all driven devices, made before they are needed."""

    def __init__(
        self,
        share: Share,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        missing: Callable[[TypeMissing], None],
    ) -> None:
        """Make them."""
        self._rules = {
            name: device.drive for name, device in share.devices.items() if device.drive is not None
        }
        self._velocity: dict[str, tuple[Any, Any]] = {}
        self._stops: dict[str, tuple[Any, Any]] = {}
        self._broken = False
        for name, rule in self._rules.items():
            # Never latched: a velocity must not reach a robot that comes later.
            wanted: list[tuple[dict[str, tuple[Any, Any]], str, str, Any]] = [
                (self._velocity, rule.message, rule.topic, DurabilityPolicy.VOLATILE)
            ]
            if rule.stop.topic:
                latched = DurabilityPolicy.TRANSIENT_LOCAL
                wanted.append((self._stops, BOOL, rule.stop.topic, latched))
            for where, type_name, topic, durability in wanted:
                try:
                    kind = class_of(type_name, topic)
                except TypeMissing as error:
                    missing(error)
                    continue
                where[name] = (node.create_publisher(kind, topic, _newest(durability)), kind())

    def drive(self, device: str, linear: float, angular: float) -> None:
        """Publish a velocity."""
        found = self._velocity.get(device)
        if found is not None:
            publisher, message = found
            velocity_message(self._rules[device], message, linear, angular)
            self._publish(publisher, message)

    def stop(self, device: str, *, stopped: bool) -> None:
        """Publish STOP or its end."""
        found = self._stops.get(device)
        if found is not None:
            publisher, message = found
            message.data = stopped
            self._publish(publisher, message)

    def _publish(self, publisher: Any, message: Any) -> None:  # noqa: ANN401
        try:
            publisher.publish(message)
        except RuntimeError as error:
            # All that rclpy raises here; it means that ROS is gone, which the adapter's thread
            # tells in its own way.
            if not self._broken:
                self._broken = True
                log.warning("ROS 2 takes no velocities: %s", error)


def _newest(durability: Any) -> Any:  # noqa: ANN401
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=1,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=durability,
    )
