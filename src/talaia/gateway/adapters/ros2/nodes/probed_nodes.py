"""What a probe asks the nodes of a graph: their life cycle and their parameters. Only reads."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, NamedTuple

from lifecycle_msgs.srv import GetState
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters

from talaia.gateway.adapters.ros2.nodes.parameters import value_of
from talaia.model.discovery.left_out_parameters import reason_to_leave
from talaia.model.discovery.probe_report import NodeFound, ParameterFound

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

__all__ = ["ProbedNodes"]

_CHANGES_STATE = "lifecycle_msgs/srv/ChangeState"
# A robot with more is asked for these.
_MAX_NODES = 200
_MAX_PARAMETERS = 500
_TYPES = {
    ParameterType.PARAMETER_BOOL: "boolean",
    ParameterType.PARAMETER_INTEGER: "integer",
    ParameterType.PARAMETER_DOUBLE: "number",
    ParameterType.PARAMETER_STRING: "text",
    ParameterType.PARAMETER_BYTE_ARRAY: "bytes",
    ParameterType.PARAMETER_BOOL_ARRAY: "booleans",
    ParameterType.PARAMETER_INTEGER_ARRAY: "integers",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "numbers",
    ParameterType.PARAMETER_STRING_ARRAY: "texts",
}
# What every node has, or ROS itself: nobody reads it on a page.
_COMMON = ("use_sim_time", "start_type_description_service", "start_parameter_services")
_COMMON_PREFIXES = ("qos_overrides.", "diagnostic_updater.")


class _Endings(NamedTuple):
    """The type of a service and the last part of its name, for each question."""

    list: tuple[Any, str] = (ListParameters, "list_parameters")
    describe: tuple[Any, str] = (DescribeParameters, "describe_parameters")
    values: tuple[Any, str] = (GetParameters, "get_parameters")
    state: tuple[Any, str] = (GetState, "get_state")


_ASK = _Endings()


class _Node:
    """One node, and what it has answered."""

    def __init__(self, name: str) -> None:
        self.name = name  # Absolute.
        self.lifecycle = False  # It offers to change its state.
        self.state = ""  # Empty until it has answered.
        self.publishes: tuple[str, ...] = ()
        # Of its parameters, without those that all nodes have; the next two are in its order.
        self.names: tuple[str, ...] = ()
        self.descriptors: tuple[Any, ...] = ()
        self.values: tuple[Any, ...] = ()


class ProbedNodes:
    """Asks the nodes of one graph; its own node must be spun."""

    def __init__(self, node: Any) -> None:  # noqa: ANN401 - rclpy ships no types
        """Take the probe's node."""
        self._node = node
        self._nodes: dict[str, _Node] = {}  # By absolute name.
        # Clients by service; those in `_asked` have been called.
        self._clients: dict[str, Any] = {}
        self._asked: set[str] = set()
        self._open = 0  # Calls without an answer yet.

    @property
    def waiting(self) -> bool:
        """Whether a node that was asked has not answered."""
        return self._open > 0

    def ask(self) -> None:
        """Ask those that can be asked now; called again, the others."""
        for name, space in self._node.get_node_names_and_namespaces()[:_MAX_NODES]:
            full = f"{space.rstrip('/')}/{name}"
            # The probe itself is no part of the robot.
            if full == self._node.get_fully_qualified_name():
                continue
            # It may have left meanwhile.
            with contextlib.suppress(Exception):
                self._ask_node(self._nodes.setdefault(full, _Node(full)), name, space)

    def found(self) -> Iterator[NodeFound]:
        """Tell what was answered, of nodes that have a life cycle or parameters."""
        for _, node in sorted(self._nodes.items()):
            parameters, left_out = _read_parameters(node)
            if node.lifecycle or parameters or left_out:
                yield NodeFound(
                    node=node.name,
                    lifecycle=node.lifecycle,
                    state=node.state,
                    publishes=node.publishes,
                    parameters=tuple(parameters),
                    left_out=tuple(left_out),
                )

    def _ask_node(self, found: _Node, name: str, space: str) -> None:
        offered = dict(self._node.get_service_names_and_types_by_node(name, space))
        published = self._node.get_publisher_names_and_types_by_node(name, space)
        # Which device it belongs to goes by what it publishes.
        found.publishes = tuple(sorted(topic for topic, _ in published))
        found.lifecycle = _CHANGES_STATE in offered.get(f"{found.name}/change_state", ())
        if found.lifecycle:
            self._call(found, _ASK.state, {}, lambda answer: _keep_state(found, answer))

        def on_names(answer: Any) -> None:  # noqa: ANN401
            found.names = _wanted(answer.result.names)
            self._ask_parameters(found)

        if f"{found.name}/list_parameters" in offered:
            for ending in (_ASK.describe, _ASK.values):
                # Made before they are needed: services are discovered one after the other.
                self._client_for(found, ending)
            # Asked once; what its answer leads to may have to wait for its services.
            self._call(found, _ASK.list, {}, on_names)
            self._ask_parameters(found)

    def _ask_parameters(self, found: _Node) -> None:
        if found.names:
            asked = {"names": list(found.names)}
            self._call(found, _ASK.describe, asked, lambda said: _keep_forms(found, said))
            self._call(found, _ASK.values, asked, lambda said: _keep_values(found, said))

    def _client_for(self, found: _Node, ending: tuple[Any, str]) -> Any:  # noqa: ANN401
        kind, last = ending
        service = f"{found.name}/{last}"
        if service not in self._clients:
            self._clients[service] = self._node.create_client(kind, service)
        return self._clients[service]

    def _call(
        self,
        found: _Node,
        ending: tuple[Any, str],
        asked: dict[str, Any],
        keep: Callable[[Any], None],
    ) -> None:
        client = self._client_for(found, ending)
        # Each is asked once; one that is not discovered yet at the next look.
        if client.srv_name in self._asked or not client.service_is_ready():
            return
        self._asked.add(client.srv_name)
        self._open += 1

        def on_answer(future: Any) -> None:  # noqa: ANN401
            self._open -= 1
            keep(future.result())

        client.call_async(ending[0].Request(**asked)).add_done_callback(on_answer)


def _keep_state(found: _Node, answer: Any) -> None:  # noqa: ANN401
    found.state = answer.current_state.label


def _keep_forms(found: _Node, answer: Any) -> None:  # noqa: ANN401
    found.descriptors = tuple(answer.descriptors)


def _keep_values(found: _Node, answer: Any) -> None:  # noqa: ANN401
    found.values = tuple(answer.values)


def _wanted(names: Iterable[str]) -> tuple[str, ...]:
    own = (
        name
        for name in sorted(names)
        if name not in _COMMON and not name.startswith(_COMMON_PREFIXES)
    )
    return tuple(own)[:_MAX_PARAMETERS]


def _read_parameters(node: _Node) -> tuple[list[ParameterFound], list[str]]:
    parameters: list[ParameterFound] = []
    left_out: list[str] = []
    for name, form, value in zip(node.names, node.descriptors, node.values, strict=False):
        kind = _TYPES.get(value.type)
        # One that is not set is of no kind.
        reason = reason_to_leave(name, kind, len(str(value_of(value))))
        if reason or kind is None:
            left_out.append(f"{name}: {reason}")
        else:
            parameters.append(_parameter(name, kind, form))
    return parameters, left_out


def _parameter(name: str, kind: str, form: Any) -> ParameterFound:  # noqa: ANN401
    # A parameter has a range of one kind, if any.
    ranges = [*form.integer_range, *form.floating_point_range]
    return ParameterFound(
        parameter=name,
        type=kind,
        read_only=form.read_only,
        minimum=float(ranges[0].from_value) if ranges else None,
        maximum=float(ranges[0].to_value) if ranges else None,
        description=form.description[:300],
    )
