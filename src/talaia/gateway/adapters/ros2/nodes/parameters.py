"""Parameters of ROS 2 nodes: read once a second, and set as a command. On the wait-set thread."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from rcl_interfaces.msg import Parameter, ParameterType
from rcl_interfaces.srv import GetParameters

from talaia.gateway.adapters.ros2.nodes.node_readings import NodeReadings
from talaia.gateway.adapters.topic_readers import parameter_plans_of
from talaia.gateway.ports import CommandOutcome
from talaia.model.arguments import list_fields
from talaia.model.list_texts import list_text
from talaia.model.site import ArgumentType
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.topic_readers import TopicPlan
    from talaia.model.list_texts import Item
    from talaia.model.site import Command
    from talaia.wire.frames import Scalar

__all__ = ["Ros2Parameters", "as_set", "fill_list", "parameters_of", "value_of"]

MOST_ASKED = 100
_FIELDS = {
    ParameterType.PARAMETER_BOOL: "bool_value",
    ParameterType.PARAMETER_INTEGER: "integer_value",
    ParameterType.PARAMETER_DOUBLE: "double_value",
    ParameterType.PARAMETER_STRING: "string_value",
}
_LIST_FIELDS = {
    ParameterType.PARAMETER_BYTE_ARRAY: "byte_array_value",
    ParameterType.PARAMETER_BOOL_ARRAY: "bool_array_value",
    ParameterType.PARAMETER_INTEGER_ARRAY: "integer_array_value",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "double_array_value",
    ParameterType.PARAMETER_STRING_ARRAY: "string_array_value",
}
_LIST_TYPES = {
    ArgumentType.BYTES: ParameterType.PARAMETER_BYTE_ARRAY,
    ArgumentType.BOOLEANS: ParameterType.PARAMETER_BOOL_ARRAY,
    ArgumentType.INTEGERS: ParameterType.PARAMETER_INTEGER_ARRAY,
    ArgumentType.NUMBERS: ParameterType.PARAMETER_DOUBLE_ARRAY,
    ArgumentType.TEXTS: ParameterType.PARAMETER_STRING_ARRAY,
}


def parameters_of(command: Command, fields: Mapping[str, Scalar]) -> list[Any]:
    """Write values by name as the request of a node's ``set_parameters`` has them."""
    kinds = {one.field: one.type for one in command.arguments.values()}
    made = []
    for name, value in list_fields(command, fields).items():
        one = Parameter(name=name)
        match value:
            case list():
                fill_list(one.value, kinds[name], value)
            case bool():
                one.value.type, one.value.bool_value = ParameterType.PARAMETER_BOOL, value
            case int():
                one.value.type, one.value.integer_value = ParameterType.PARAMETER_INTEGER, value
            case float():
                one.value.type, one.value.double_value = ParameterType.PARAMETER_DOUBLE, value
            case str():
                one.value.type, one.value.string_value = ParameterType.PARAMETER_STRING, value
        made.append(one)
    return made


def fill_list(into: Any, kind: ArgumentType, items: list[Item]) -> None:  # noqa: ANN401
    """Put a list into a ``rcl_interfaces/msg/ParameterValue``."""
    into.type = _LIST_TYPES[kind]
    # rclpy wants each byte as bytes of length one.
    made = [bytes([int(item)]) for item in items] if kind is ArgumentType.BYTES else items
    setattr(into, _LIST_FIELDS[into.type], made)


def value_of(value: Any) -> Scalar | None:  # noqa: ANN401
    """Read a ``rcl_interfaces/msg/ParameterValue``; a list as text; none where it is not set."""
    if (field := _FIELDS.get(value.type)) is not None:
        scalar: Scalar = getattr(value, field)
        return scalar
    if (field := _LIST_FIELDS.get(value.type)) is not None:
        values = getattr(value, field)
        # Arrays of numpy's (through a bridge) hold numbers that JSON does not know.
        return list_text(values.tolist() if hasattr(values, "tolist") else values)
    return None


def as_set(response: Any) -> CommandOutcome:  # noqa: ANN401 - ROS's packages are untyped
    """Read the answer of ``set_parameters``: a node says for each whether it took it."""
    refused = [result.reason for result in response.results if not result.successful]
    if refused:
        reason = "; ".join(refused)[:2000]
        return CommandOutcome(CommandPhase.FAILED, reason or "the node does not take it")
    return CommandOutcome(CommandPhase.SUCCEEDED, "set")


class _Node(NamedTuple):
    """A node that is asked: its client, and by parameter name what takes the value.

    ``asked`` has the names of each request that is under way, in order.
    """

    client: Any
    plans: dict[str, list[TopicPlan]]
    asked: dict[int, tuple[str, ...]]


class Ros2Parameters(NodeReadings[_Node]):
    """The parameters that signals are made of."""

    def redescribe(self, scope: ConnectionScope) -> None:
        """Ask for the parameters of this scope; nodes that are asked already stay so."""
        before = {plan.channel: plan for plan in self.plans}
        self.plans = parameter_plans_of(scope, self._latest, self._complain)
        owners = {plan.topic.rpartition("/")[0] for plan in self.plans}
        for owner in self._nodes.keys() - owners:
            client = self._nodes.pop(owner).client
            self._thread.remove_client(client.handle)
            self._node.destroy_client(client)
        for one in self._nodes.values():
            # Answers that are under way find the new plans by name.
            one.plans.clear()
        for plan in self.plans:
            if (was := before.get(plan.channel)) is not None:
                plan.take_over(was)
            owner, _, name = plan.topic.rpartition("/")
            if owner not in self._nodes:
                client = self._node.create_client(GetParameters, f"{owner}/get_parameters")
                self._nodes[owner] = _Node(client, {}, {})
                taker = self._values_reader(self._nodes[owner])
                self._thread.add_client(client.handle, GetParameters.Response, taker)
            self._nodes[owner].plans.setdefault(name, []).append(plan)

    def ask(self) -> None:
        """Ask every node that is there."""
        for one in self._nodes.values():
            if one.client.service_is_ready():
                request = GetParameters.Request(names=list(one.plans))
                number = one.client.handle.send_request(request)
                # Nodes that never answer must not fill the memory.
                if len(one.asked) >= MOST_ASKED:
                    one.asked.pop(next(iter(one.asked)))
                one.asked[number] = tuple(one.plans)

    def _values_reader(self, one: _Node) -> Callable[[int, Any], None]:
        def on_values(number: int, response: Any) -> None:  # noqa: ANN401
            now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
            names = one.asked.pop(number, ())
            for name, value in zip(names, response.values, strict=False):
                plans = one.plans.get(name, [])
                read = value_of(value)
                # Of one that is not set there is nothing to tell.
                if read is None:
                    continue
                message = SimpleNamespace(data=read)
                for plan in plans:
                    plan.read_message(message, now_us, now_ns, self._gathered)

        return on_values
