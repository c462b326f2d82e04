"""The command-line clients for ROS 1: the same words and answers as `client`'s."""

from __future__ import annotations

import os
import sys
import time

import rosgraph
import rospy
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from talaia.sim.observatory.client_requests import ClientRequest, parse_request

__all__ = ["main"]

FIND_S = 5.0


def main(argv: list[str]) -> int:
    """Ask one thing: the device, then its words; 0 when the server did it, else 1."""
    good, said = _answer_of(parse_request(argv[0], argv[1:]))
    sys.stdout.write(f" {said}\n")
    sys.stdout.flush()
    return 0 if good else 1


def _answer_of(request: ClientRequest) -> tuple[bool, str]:
    uri = os.environ.setdefault("ROS_MASTER_URI", "http://localhost:11311")
    if not rosgraph.is_master_online(uri):
        return False, f"no ROS master answers at {uri}"
    name = f"{request.device}_client_{os.getpid()}"
    if request.kind == "fault":
        rospy.init_node(name, disable_signals=True, disable_rosout=True)
        return _publish_fault(str(request.values["data"]))
    # A service is called without becoming a node: that saves most of a client's time.
    path = f"/{request.device}/{request.name}"
    try:
        rospy.wait_for_service(path, FIND_S)
    except rospy.ROSException:
        return False, f"there is no {request.device} server"
    try:
        if request.kind == "switch":
            answer = rospy.ServiceProxy(path, SetBool)(request.values["data"])
        else:
            # No standard request of ROS 1 has numbers: they go by the parameter server.
            for key, value in request.values.items():
                rosgraph.Master(f"/{name}").setParam(f"{path}/{key}", value)
            answer = rospy.ServiceProxy(path, Trigger)()
    except rospy.ServiceException as error:
        return False, f"the {request.device} server does not answer ({error})"
    return answer.success, answer.message


def _publish_fault(words: str) -> tuple[bool, str]:
    publisher = rospy.Publisher("/observatory/fault", String, queue_size=10)
    until = time.monotonic() + FIND_S
    while publisher.get_num_connections() < 1:
        if time.monotonic() > until:
            return False, "there is no observatory"
        time.sleep(0.05)
    # As in `client`: each server listens for itself.
    for _ in range(5):
        publisher.publish(String(words))
        time.sleep(0.2)
    return True, words
