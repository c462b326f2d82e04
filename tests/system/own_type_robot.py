"""A ROS 2 robot with types of its own that exist nowhere else, started as a script.

No package on this machine has them: messages, hashes and the answers to ``~/get_type_description``
are made by `rosbags` of the texts here and of the ``.srv`` file in the folder that is named. Each
number on stdin is published once; what is called and heard is written to stdout.
"""

from __future__ import annotations

import os
import select
import sys
from pathlib import Path
from typing import Any

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from type_description_interfaces.msg import Field, FieldType, IndividualTypeDescription
from type_description_interfaces.srv import GetTypeDescription

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, made_class
from talaia.gateway.adapters.ros2.rclpy_bridge.made_service_class import MadeMessage, made_service

PACKAGE = "oven_own_msgs"
BAKE, SHELF, ORDER = (f"{PACKAGE}/msg/{name}" for name in ("Bake", "Shelf", "Order"))
PREHEAT = f"{PACKAGE}/srv/Preheat"
BAKE_TEXT = "string recipe\noven_own_msgs/Shelf[] shelves\nint32 minutes\n"
ORDER_TEXT = "string<=20 guest\noven_own_msgs/Shelf[2] shelves\n"
# As ROS has it, but that `char` is what it is to ROS and not what it is to rosbags.
EVENT_INFO = "service_msgs/msg/ServiceEventInfo"
EVENT_INFO_TEXT = (
    "uint8 event_type\nbuiltin_interfaces/Time stamp\nuint8[16] client_gid\nint64 sequence_number\n"
)
# Of type_description_interfaces/msg/FieldType.
STRING, INT32, UINT8, FLOAT64 = (
    FieldType.FIELD_TYPE_STRING,
    FieldType.FIELD_TYPE_INT32,
    FieldType.FIELD_TYPE_UINT8,
    FieldType.FIELD_TYPE_DOUBLE,
)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def field(name: str, number: int, nested: str = "", capacity: int = 0) -> Field:
    kind = FieldType(type_id=number, nested_type_name=nested)
    # Of an array its size, of a bounded text its bound.
    if number == FieldType.FIELD_TYPE_BOUNDED_STRING:
        kind.string_capacity = capacity
    else:
        kind.capacity = capacity
    return Field(name=name, type=kind)


# What `~/get_type_description` says of messages; of the service it says that it has its type.
DESCRIBED = {
    BAKE: [
        field("recipe", STRING),
        field("shelves", FieldType.FIELD_TYPE_NESTED_TYPE_UNBOUNDED_SEQUENCE, SHELF),
        field("minutes", INT32),
    ],
    ORDER: [
        field("guest", FieldType.FIELD_TYPE_BOUNDED_STRING, capacity=20),
        field("shelves", FieldType.FIELD_TYPE_NESTED_TYPE_ARRAY, SHELF, 2),
    ],
    PREHEAT: [],
}


def say(*words: object) -> None:
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


def own_types(folder: Path) -> Any:
    """Register all types, the service as ROS forms it: a message of request, answer and event."""
    store = get_typestore(Stores.EMPTY)
    texts = {
        EVENT_INFO: EVENT_INFO_TEXT,
        BAKE: BAKE_TEXT,
        ORDER: ORDER_TEXT,
        SHELF: (folder / PACKAGE / "msg" / "Shelf.msg").read_text(),
    }
    asked, answered = (folder / PACKAGE / "srv" / "Preheat.srv").read_text().split("---\n")
    store.register(get_types_from_msg("int32 sec\nuint32 nanosec\n", "builtin_interfaces/msg/Time"))
    for name, text in texts.items():
        store.register(get_types_from_msg(text, name))
    for ending, text in (("Request", asked), ("Response", answered)):
        # rosbags takes each name for a message's.
        found = get_types_from_msg(text, f"{PACKAGE}/msg/Preheat_{ending}")
        store.register({f"{PREHEAT}_{ending}": next(iter(found.values()))})

    def part(ending: str) -> Any:
        return (Nodetype.NAME, f"{PREHEAT}_{ending}")

    event = [
        ("info", (Nodetype.NAME, EVENT_INFO)),
        ("request", (Nodetype.SEQUENCE, (part("Request"), 1))),
        ("response", (Nodetype.SEQUENCE, (part("Response"), 1))),
    ]
    store.register({f"{PREHEAT}_Event": ([], event)})
    whole = [
        (f"{ending.lower()}_message", part(ending)) for ending in ("Request", "Response", "Event")
    ]
    store.register({PREHEAT: ([], whole)})
    return store


class Oven(Node):
    """Publishes, hears and serves its types, and describes them to whoever asks by their hash."""

    def __init__(self, folder: Path) -> None:  # noqa: D107
        described = Parameter("start_type_description_service", value=False)
        super().__init__("oven", parameter_overrides=[described])
        self.types = own_types(folder)
        self.hashes = {name: self.types.hash_rihs01(name) for name in DESCRIBED}
        bake, order = (made_class(name, self.hashes[name]) for name in (BAKE, ORDER))
        self.publisher = self.create_publisher(bake, "/oven/bake", LATCHED)
        self.create_subscription(order, "/oven/orders", self.hear, 10, raw=True)
        kind = made_service(PREHEAT, self.hashes[PREHEAT])
        self.create_service(kind, "/oven/preheat", self.preheat)
        forget_error()
        self.create_service(GetTypeDescription, "/oven/get_type_description", self.describe)

    def describe(
        self, request: GetTypeDescription.Request, answer: GetTypeDescription.Response
    ) -> GetTypeDescription.Response:
        name = request.type_name
        answer.successful = self.hashes.get(name) == request.type_hash
        if answer.successful:
            answer.type_description.type_description = IndividualTypeDescription(
                type_name=name, fields=DESCRIBED[name]
            )
            answer.type_description.referenced_type_descriptions = [
                IndividualTypeDescription(
                    type_name=SHELF, fields=[field("number", UINT8), field("celsius", FLOAT64)]
                )
            ]
        return answer

    def publish(self, celsius: float) -> None:
        shelf, whole = (self.types.types[name] for name in (SHELF, BAKE))
        shelves = [shelf(number=1, celsius=-1.0), shelf(number=2, celsius=celsius)]
        message = whole(recipe="bread", shelves=shelves, minutes=40)
        self.publisher.publish(bytes(self.types.serialize_cdr(message, BAKE)))

    def hear(self, raw: bytes) -> None:
        order = self.types.deserialize_cdr(raw, ORDER)
        say("ordered", order.guest, *(f"{each.number}:{each.celsius}" for each in order.shelves))

    def preheat(self, request: MadeMessage, _: MadeMessage) -> MadeMessage:
        asked = self.types.deserialize_cdr(request.raw, f"{PREHEAT}_Request")
        say("preheated", asked.shelf.number, asked.shelf.celsius)
        good = asked.shelf.celsius <= 300
        answer = self.types.types[f"{PREHEAT}_Response"](
            success=good, message=f"shelf {asked.shelf.number} " + ("glows" if good else "melts")
        )
        raw = bytes(self.types.serialize_cdr(answer, f"{PREHEAT}_Response"))
        return made_service(PREHEAT, self.hashes[PREHEAT]).Response(raw)


def main() -> None:
    rclpy.init()
    node = Oven(Path(sys.argv[1]))
    # One thread: the answers of made classes are written by Python from within the middleware.
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    say("ready")
    rest = b""
    while True:
        if select.select([0], [], [], 0)[0]:
            more = os.read(0, 4096)
            if not more:
                break
            *lines, rest = (rest + more).split(b"\n")
            for line in lines:
                node.publish(float(line))
        executor.spin_once(timeout_sec=0.02)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
