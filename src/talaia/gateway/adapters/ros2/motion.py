"""Driving and STOP as ROS 2 publications. Called from the event loop: nothing here waits."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from talaia.gateway.adapters.ros2.made_types.packageless_motion import PackagelessMotion
from talaia.gateway.adapters.ros2.requests import class_of, fill, velocity_message
from talaia.gateway.adapters.ros2.system_ros.start import guard_velocity
from talaia.gateway.adapters.velocity import guard_mark, stamp_fields, zero_of
from talaia.gateway.driving.drive_keys import HALT
from talaia.gateway.errors import TypeMissing
from talaia.model.site import DriveMessage
from talaia.model.twins.twin_topics import twin_drive

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.topic_types import TopicTypes
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.model.site import Drive

__all__ = ["Ros2Motion"]

log = logging.getLogger(__name__)
BOOL = "std_msgs/msg/Bool"


class Ros2Motion:
    """The publishers of all driven devices, made before they are needed."""

    def __init__(
        self,
        scope: ConnectionScope,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        *,
        types: TopicTypes,
        missing: Callable[[TypeMissing], None],
    ) -> None:
        """Make them. From here on it is called on the wait-set thread, but for the velocities."""
        self._node, self._missing = node, missing
        self._thread, self._types = thread, types
        # Devices whose type is not installed here.
        self._packageless: dict[str, PackagelessMotion] = {}
        self._rules: dict[str, Drive] = {}
        self._velocity: dict[str, tuple[Any, Any]] = {}
        self._stops: dict[str, tuple[Any, Any]] = {}
        self._broken = False
        self.redescribe(scope)

    def close(self) -> None:
        """Look for no listeners any more; the node and its publishers end together."""
        for bare in self._packageless.values():
            bare.close()

    def redescribe(self, scope: ConnectionScope) -> None:
        """Make the publishers of devices whose driving is described anew; the others stay.

        Nobody drives those now: their zeros have been published.
        """
        rules = {
            name: device.drive for name, device in scope.devices.items() if device.drive is not None
        }
        # A twin is driven on a topic of its own, by the limits of the device that it is of.
        for name, device in scope.devices.items():
            real = None if device.twin is None else scope.devices.get(device.twin.of)
            if real is not None and real.drive is not None:
                rules[name] = twin_drive(real.drive, name)
        before, self._rules = self._rules, rules
        for name in [name for name, rule in before.items() if rules.get(name) != rule]:
            if (bare := self._packageless.pop(name, None)) is not None:
                bare.close()
            for where in (self._velocity, self._stops):
                publisher, _ = where.pop(name, (None, None))
                if publisher is not None:
                    self._node.destroy_publisher(publisher)
        for name, rule in rules.items():
            if before.get(name) != rule:
                self._make(name, rule)

    def _make(self, name: str, rule: Drive) -> None:
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
                if where is self._velocity:
                    self._packageless[name] = PackagelessMotion(
                        rule, self._node, self._thread, types=self._types, missing=self._missing
                    )
                else:
                    self._missing(error)
                continue
            # Characters may add up at the robot: none takes another's place before it is sent.
            depth = 20 if type_name == DriveMessage.KEYS else 1
            publisher = self._node.create_publisher(kind, topic, _newest(durability, depth))
            where[name] = (publisher, kind())
            if where is self._velocity:
                zero = velocity_message(rule, kind(), zero_of(rule), HALT)
                marked = velocity_message(rule, kind(), zero_of(rule), HALT)
                fill(marked, guard_mark(rule))
                guard_velocity(publisher, zero, marked)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Publish a velocity, or the character that stands for it."""
        found = self._velocity.get(device)
        if found is not None:
            publisher, message = found
            rule = self._rules[device]
            velocity_message(rule, message, demand, key)
            if stamp := stamp_fields(rule, self._now_ns):
                fill(message, stamp)
            self._publish(publisher, message)
        elif (bare := self._packageless.get(device)) is not None:
            self._publish(bare, demand)

    def _now_ns(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

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


def _newest(durability: Any, depth: int) -> Any:  # noqa: ANN401
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=durability,
    )
