"""``talaia sim run``: the observatory's command-line programs, in place of ``ros2 run``.

    talaia sim run dome_servcli client status
    talaia sim run telescope_servcli client goto 5.59 -5.39
    talaia sim run dome_servcli server

A client prints the server's answer as the founding design's did: a blank, the words, a line end.
"""

from __future__ import annotations

import os
import sys
import time
from typing import TYPE_CHECKING, Any

from talaia.ros_installation import ForeignRos, use_ros
from talaia.sim.observatory.client_requests import (
    PROGRAMS,
    ClientRequest,
    InvalidRequest,
    parse_request,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["answer_of", "main"]

# How long a server is looked for (s).
FIND_S = 5.0
# Longer than any motion here takes; an exposure adds its own length.
ANSWER_S = 120.0


def main(argv: Sequence[str]) -> int:
    """Run one program; 0 when the server did it, 1 when not, 2 for words that are wrong."""
    words = list(argv)
    # It has to stand first: what comes behind belongs to the program.
    ros1 = "--ros1" in words[:1]
    program, *rest = words[1:] if ros1 else words or [""]
    device = PROGRAMS.get(program, "")
    if not device or not rest or rest[0] not in ("client", "server"):
        programs = ", ".join(PROGRAMS)
        sys.stderr.write(
            "usage: talaia sim run [--ros1] PROGRAM client ACTION … | PROGRAM server\n"
            f"programs: {programs}\n"
        )
        return 2
    if rest[0] == "server":
        from talaia.sim.observatory.run import main as serve

        return serve([*(["--ros1"] if ros1 else []), "--only", device, *rest[1:]])
    try:
        request = parse_request(device, rest[1:])
    except InvalidRequest as error:
        # Where the server's answer would stand.
        sys.stdout.write(f" {error}\n")
        return 1
    if ros1:
        from talaia.sim.observatory.ros1_start import run_ros1

        return run_ros1("ros1_client", [device, *rest[1:]])
    good, said = answer_of(request)
    sys.stdout.write(f" {said}\n")
    return 0 if good else 1


def answer_of(request: ClientRequest) -> tuple[bool, str]:
    """Ask the server, and wait for its answer; tell whether it was done, and its words."""
    # The middleware of the simulator's own servers; see `ros_domain.domain_environment`.
    os.environ.setdefault("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    try:
        use_ros()
        import rclpy
        from rclpy.signals import SignalHandlerOptions
    except (ForeignRos, ImportError) as error:
        return False, f"the ROS 2 packages cannot be imported ({error})"
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node(
        # Several clients may run at once, and nodes' names must differ.
        f"{request.device}_client_{os.getpid()}",
        enable_rosout=False,
        start_parameter_services=False,
    )
    try:
        if request.kind == "fault":
            return _publish_fault(node, request)
        return _call_service(node, request)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _call_service(node: Any, request: ClientRequest) -> tuple[bool, str]:  # noqa: ANN401 - rclpy has no types
    import rclpy
    from rcl_interfaces.srv import SetParametersAtomically
    from rclpy.parameter import Parameter
    from std_srvs.srv import SetBool, Trigger

    kinds = {"trigger": Trigger, "switch": SetBool, "ask": SetParametersAtomically}
    kind = kinds[request.kind]
    client = node.create_client(kind, f"/{request.device}/{request.name}")
    if not client.wait_for_service(FIND_S):
        return False, f"there is no {request.device} server"
    message = kind.Request()
    if request.kind == "switch":
        message.data = request.values["data"]
    elif request.kind == "ask":
        message.parameters = [
            Parameter(name, value=value).to_parameter_msg()
            for name, value in request.values.items()
        ]
    # An exposure is answered only when it has ended.
    seconds = request.values.get("seconds", 0.0)
    within = ANSWER_S + (seconds if isinstance(seconds, float) else 0.0)
    future = client.call_async(message)
    rclpy.spin_until_future_complete(node, future, timeout_sec=within)
    if not future.done():
        return False, f"the {request.device} server does not answer"
    answer = future.result()
    if request.kind == "ask":
        return answer.result.successful, answer.result.reason
    return answer.success, answer.message


def _publish_fault(node: Any, request: ClientRequest) -> tuple[bool, str]:  # noqa: ANN401
    from std_msgs.msg import String

    words = str(request.values["data"])
    publisher = node.create_publisher(String, "/observatory/fault", 10)
    until = time.monotonic() + FIND_S
    while publisher.get_subscription_count() < 1:
        if time.monotonic() > until:
            return False, "there is no observatory"
        time.sleep(0.02)
    # Each server listens for itself, and not all may be found by now; told twice is told once.
    for _ in range(5):
        publisher.publish(String(data=words))
        time.sleep(0.2)
    # What is not sent by then is lost with the process.
    publisher.wait_for_all_acked()
    return True, words
