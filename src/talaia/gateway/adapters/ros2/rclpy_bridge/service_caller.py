"""Calls services whose types are not installed, in a process and a thread of its own.

JSON lines in, JSON lines out; ended by the end of its input, or with SIGKILL when it hangs. See
`made_service_class` for why neither a gateway nor a bridge does this in its own process. A request
goes out only after the node that offers the service has confirmed the hash of its type: by another
version's definition it would be taken for something else. Run by whichever Python has rclpy.
"""

from __future__ import annotations

import base64
import contextlib
import json
import os
import select
import sys
import time
from typing import Any, NamedTuple

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from .made_message_class import CannotMakeClass, forget_error
from .made_service_class import made_service

try:
    from type_description_interfaces.srv import GetTypeDescription
except ImportError:
    # Humble has no such service.
    GetTypeDescription = None

__all__ = ["main"]

_TURN_S = 0.02
_IDLE_S = 1.0
_TELLS_NOTHING = (
    "the node {owner} does not say which version of {type} it has; install the type's package "
    "where the gateway runs"
)
# For the discovery of a service that a client was just made for.
_PATIENCE_S = 8.0


class _Call(NamedTuple):
    """One call: its number, what is called, and until when it may wait to begin (monotonic, s)."""

    number: int
    service: str
    type_name: str
    type_hash: str
    request: bytes
    until_s: float


class _Caller:
    """One node and its clients."""

    def __init__(self, node: Node) -> None:
        self._node = node
        # By service, type and hash; made once, for discovery takes a moment.
        self._clients: dict[tuple[str, str, str], Any] = {}
        # Who answers for the types of a node, by the node's full name.
        self._describers: dict[str, Any] = {}
        # Services whose type and version were confirmed, with their owner.
        self._confirmed: set[tuple[str, str, str, str]] = set()
        # Numbers of calls whose node was asked for its version.
        self._asked: set[int] = set()
        # Not sent yet.
        self._waiting: list[_Call] = []
        # Sent, and not answered.
        self._open: set[int] = set()

    @property
    def busy(self) -> bool:
        """Whether a call waits for anything."""
        return bool(self._waiting or self._open)

    def begin_call(self, order: dict[str, Any]) -> None:
        """Take a call."""
        call = _Call(
            order["number"],
            order["service"],
            order["type"],
            order["hash"],
            base64.b64decode(order["request"]),
            time.monotonic() + _PATIENCE_S,
        )
        self._waiting.append(call)

    def go_on(self) -> None:
        """Send what can be sent now; tell what cannot be."""
        waiting, self._waiting = self._waiting, []
        for call in waiting:
            try:
                problem = self._try_call(call)
            except CannotMakeClass as error:
                self._refuse_call(call, str(error))
                continue
            if not problem:
                continue
            # What is missing may come: services are discovered one after the other.
            if time.monotonic() > call.until_s:
                self._refuse_call(call, problem)
            else:
                self._waiting.append(call)

    def _try_call(self, call: _Call) -> str:
        """Go one step; give what is missing, or nothing when it was sent or refused."""
        # Anew for each call: another node may offer it now, in another version.
        owner, types = self._find_owner(call.service)
        if not owner:
            return f"the robot does not offer {call.service} now"
        if call.type_name not in types:
            said = " and ".join(types)
            self._refuse_call(call, f"{call.service} is of type {said}, not {call.type_name}")
            return ""
        if (call.service, call.type_name, call.type_hash, owner) not in self._confirmed:
            return self._confirm_version(call, owner)
        client = self._client_for(call)
        if not client.service_is_ready():
            return f"the robot does not offer {call.service} now"
        kind = made_service(call.type_name, call.type_hash)

        def on_answer(future: Any) -> None:  # noqa: ANN401
            self._open.discard(call.number)
            print_row(number=call.number, answer=base64.b64encode(future.result().raw).decode())

        # Told before it is sent: from here on nobody can say that the robot did nothing.
        self._open.add(call.number)
        print_row(number=call.number, sent=True)
        client.call_async(kind.Request(call.request)).add_done_callback(on_answer)
        return ""

    def _confirm_version(self, call: _Call, owner: str) -> str:
        """Ask a service's node whether it has this version of its type."""
        if GetTypeDescription is None:
            return _TELLS_NOTHING.format(owner=owner, type=call.type_name)
        describer = self._describers.get(owner)
        if describer is None:
            name = f"{owner}/get_type_description"
            describer = self._describers[owner] = self._node.create_client(GetTypeDescription, name)
        if not describer.service_is_ready():
            return _TELLS_NOTHING.format(owner=owner, type=call.type_name)
        if call.number not in self._asked:
            self._asked.add(call.number)
            request = GetTypeDescription.Request(
                type_name=call.type_name, type_hash=call.type_hash, include_type_sources=False
            )

            def on_answer(future: Any) -> None:  # noqa: ANN401
                found = future.result()
                # ROS looks types up by their hash alone.
                name = found.type_description.type_description.type_name
                if found.successful and name == call.type_name:
                    key = (call.service, call.type_name, call.type_hash, owner)
                    self._confirmed.add(key)
                elif call in self._waiting:
                    self._waiting.remove(call)
                    self._refuse_call(
                        call,
                        f"the node {owner} has another version of {call.type_name} than the one "
                        f"that is known here, {call.type_hash}",
                    )

            describer.call_async(request).add_done_callback(on_answer)
        return f"the node {owner} does not answer"

    def _client_for(self, call: _Call) -> Any:  # noqa: ANN401
        key = (call.service, call.type_name, call.type_hash)
        client = self._clients.get(key)
        if client is None:
            kind = made_service(call.type_name, call.type_hash)
            client = self._clients[key] = self._node.create_client(kind, call.service)
            forget_error()
        return client

    def _find_owner(self, service: str) -> tuple[str, list[str]]:
        """Find the node that offers a service, and the types that it gives it."""
        for name, space in self._node.get_node_names_and_namespaces():
            with contextlib.suppress(Exception):  # it may have left meanwhile
                offered = dict(self._node.get_service_names_and_types_by_node(name, space))
                if service in offered:
                    return f"{space.rstrip('/')}/{name}", offered[service]
        return "", []

    @staticmethod
    def _refuse_call(call: _Call, why: str) -> None:
        print_row(number=call.number, refused=why)


def print_row(**row: object) -> None:
    """Write a line."""
    sys.stdout.write(json.dumps(row) + "\n")
    sys.stdout.flush()


def main(node_name: str) -> None:
    """Serve until the input ends, with a node of this name."""
    # Nothing of ours belongs into the robot's log.
    rclpy.init(args=["--ros-args", "--disable-rosout-logs", "--disable-external-lib-logs"])
    quiet = Parameter("start_type_description_service", value=False)
    node = Node(
        node_name,
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[quiet],
    )
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    caller, rest = _Caller(node), b""
    while True:
        # While nothing is under way it waits for orders, and costs nothing.
        if select.select([0], [], [], 0 if caller.busy else _IDLE_S)[0]:
            more = os.read(0, 65536)
            if not more:
                break
            *lines, rest = (rest + more).split(b"\n")
            for line in lines:
                caller.begin_call(json.loads(line))
        caller.go_on()
        executor.spin_once(timeout_sec=_TURN_S)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()
