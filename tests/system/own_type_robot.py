"""A ROS 2 robot with a message type that exists nowhere else, started as a script.

No package on this machine has it: messages, hash and the answer to ``~/get_type_description`` are
made by `rosbags` of the text below. Each word on stdin is published once, as a number.
"""

from __future__ import annotations

import sys
import threading

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from type_description_interfaces.msg import Field, FieldType, IndividualTypeDescription
from type_description_interfaces.srv import GetTypeDescription

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, made_class

TYPE, PART = "oven_own_msgs/msg/Bake", "oven_own_msgs/msg/Shelf"
TEXT = "string recipe\noven_own_msgs/Shelf[] shelves\nint32 minutes\n"
PART_TEXT = "uint8 number\nfloat64 celsius\n"
# Of type_description_interfaces/msg/FieldType.
STRING, INT32, UINT8, FLOAT64 = (
    FieldType.FIELD_TYPE_STRING,
    FieldType.FIELD_TYPE_INT32,
    FieldType.FIELD_TYPE_UINT8,
    FieldType.FIELD_TYPE_DOUBLE,
)


def field(name: str, number: int, nested: str = "") -> Field:
    return Field(name=name, type=FieldType(type_id=number, nested_type_name=nested))


class Oven(Node):
    """Publishes the type, and describes it to whoever asks by its hash."""

    def __init__(self) -> None:  # noqa: D107
        described = Parameter("start_type_description_service", value=False)
        super().__init__("oven", parameter_overrides=[described])
        self.types = get_typestore(Stores.EMPTY)
        self.types.register(get_types_from_msg(PART_TEXT, PART))
        self.types.register(get_types_from_msg(TEXT, TYPE))
        self.hash = self.types.hash_rihs01(TYPE)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.publisher = self.create_publisher(made_class(TYPE, self.hash), "/oven/bake", latched)
        forget_error()
        self.create_service(GetTypeDescription, "/oven/get_type_description", self.describe)

    def describe(
        self, request: GetTypeDescription.Request, answer: GetTypeDescription.Response
    ) -> GetTypeDescription.Response:
        answer.successful = (request.type_name, request.type_hash) == (TYPE, self.hash)
        answer.type_description.type_description = IndividualTypeDescription(
            type_name=TYPE,
            fields=[
                field("recipe", STRING),
                field("shelves", FieldType.FIELD_TYPE_NESTED_TYPE_UNBOUNDED_SEQUENCE, PART),
                field("minutes", INT32),
            ],
        )
        answer.type_description.referenced_type_descriptions = [
            IndividualTypeDescription(
                type_name=PART, fields=[field("number", UINT8), field("celsius", FLOAT64)]
            )
        ]
        return answer

    def publish(self, celsius: float) -> None:
        shelf, whole = (self.types.types[name] for name in (PART, TYPE))
        shelves = [shelf(number=1, celsius=-1.0), shelf(number=2, celsius=celsius)]
        message = whole(recipe="bread", shelves=shelves, minutes=40)
        self.publisher.publish(bytes(self.types.serialize_cdr(message, TYPE)))


def main() -> None:
    rclpy.init()
    node = Oven()

    def spin() -> None:
        try:
            rclpy.spin(node)
        except ExternalShutdownException:
            return

    spinning = threading.Thread(target=spin)
    spinning.start()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        node.publish(float(line))
    rclpy.try_shutdown()
    spinning.join()


if __name__ == "__main__":
    main()
