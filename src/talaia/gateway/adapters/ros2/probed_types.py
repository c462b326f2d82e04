"""The types of the topics that a probe listens to, installed or not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy.serialization import deserialize_message

from talaia.gateway.adapters.message_fields import ReadableFields, shape_of
from talaia.gateway.adapters.ros2.made_types.made_message_class import (
    CannotMakeTypes,
    made_class,
    problem_here,
)
from talaia.gateway.adapters.ros2.made_types.self_test import self_test_problem
from talaia.gateway.adapters.ros2.message_types import DefinedParts, kind_named, kind_of
from talaia.gateway.adapters.ros2.requests import class_of
from talaia.gateway.adapters.ros2.type_definitions.definition_finder import (
    DefinitionFinder,
    DefinitionMismatch,
)
from talaia.gateway.adapters.ros2.type_definitions.field_comments import comment_of
from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import decoder_of
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    TypeDefinition,
    type_hash,
)
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder
from talaia.gateway.adapters.ros2.type_definitions.robot_questions import (
    GetTypeDescription,
    description_in,
    hash_of,
    node_of,
)
from talaia.gateway.errors import TypeMissing

if TYPE_CHECKING:
    from collections.abc import Callable, Collection
    from pathlib import Path

    from talaia.gateway.adapters.message_fields import RosMessageType

__all__ = ["ProbedType", "ProbedTypes", "asked_of", "goal_of", "heard_message_of", "request_of"]


class ProbedType(NamedTuple):
    """How messages of a topic are read, and what their fields are.

    Attributes:
        find: gives the types of its parts, by ``package/Name``; none for one that is not known.
        comment_of: gives what the definition says beside a field of a type.

    """

    decode: Callable[[bytes], object]
    find: Callable[[str], RosMessageType | None]
    comment_of: Callable[[str, str], str]


class ProbedTypes:
    """Asks the nodes of one graph for their types; its node must be spun."""

    def __init__(self, node: Any, definitions: Path | None) -> None:  # noqa: ANN401 - rclpy ships no types
        """Take the probe's node, and a folder or recording with definitions, if there is one."""
        self._named = definitions
        self._node = node
        self._finder: DefinitionFinder | None = None
        # What nodes said, by type and hash; and the questions that are under way.
        self._described: dict[tuple[str, str], TypeDefinition | None] = {}
        self._clients: dict[str, Any] = {}
        self._asked: set[tuple[str, str]] = set()

    @property
    def waiting(self) -> bool:
        """Whether a node that was asked has not answered."""
        return len(self._asked) > len(self._described)

    def class_for(self, type_name: str, topic: str, infos: Collection[Any]) -> Any:  # noqa: ANN401
        """Give the class that a topic is subscribed with.

        Raises:
            TypeMissing: there is none, and none can be made here.

        """
        try:
            return class_of(type_name, topic)
        except TypeMissing as error:
            problem = problem_here() or self_test_problem()
            if problem:
                raise TypeMissing(type_name, topic, problem) from error
        try:
            return made_class(type_name, _spoken(infos))
        except CannotMakeTypes as error:
            raise TypeMissing(type_name, topic, str(error)) from error

    def ask(self, type_name: str, infos: Collection[Any]) -> None:
        """Ask who publishes a type for it, unless it is installed in the same version.

        May be called again: who could not be asked yet is asked then.
        """
        spoken, owner = _spoken(infos), next(map(node_of, infos), "")
        key = (type_name, spoken)
        if GetTypeDescription is None or not spoken or not owner or key in self._asked:
            return
        # The installed class says all that the node would.
        if _installed_hash(type_name) == spoken:
            return
        client = self._clients.get(owner)
        if client is None:
            client = self._node.create_client(GetTypeDescription, f"{owner}/get_type_description")
            self._clients[owner] = client
        if not client.service_is_ready():
            return
        self._asked.add(key)
        request = GetTypeDescription.Request(type_name=type_name, type_hash=spoken)

        def on_answer(future: Any) -> None:  # noqa: ANN401
            self._described[key] = description_in(future.result(), f"the node {owner}")

        client.call_async(request).add_done_callback(on_answer)

    def find(self, type_name: str, topic: str, infos: Collection[Any]) -> ProbedType:
        """Give how a topic is read.

        Raises:
            TypeMissing: nothing is known of its type.
            DefinitionMismatch: another version is known.
            BadDefinition: it cannot be decoded here.

        """
        spoken = _spoken(infos)
        installed = _installed_hash(type_name)
        if installed and spoken in ("", installed):
            kind = class_of(type_name, topic)
            return ProbedType(lambda raw: deserialize_message(raw, kind), kind_named, comment_of)
        described = self._described.get((type_name, spoken))
        definition = self._known_finder().find(type_name, spoken, topic, described)
        parts = DefinedParts(definition)
        decode = decoder_of(definition, proven=bool(spoken))
        return ProbedType(decode, parts.kind_named, parts.comment_of)

    def find_request(self, type_name: str, used_by: str) -> ReadableFields:
        """Give what the request of a service holds whose type is not installed.

        Raises:
            TypeMissing: nothing is known of its type, or it cannot be called here.
            BadDefinition: it cannot be written here.

        """
        service, _ = self._known_finder().find_service(type_name, used_by)
        if problem := problem_here() or self_test_problem():
            raise TypeMissing(type_name, used_by, problem)
        return _shape_of_part(service.request, f"{type_name}.srv")

    def find_goal(self, type_name: str, used_by: str) -> ReadableFields:
        """Give what the goal of an action holds whose type is not installed; see `find_request`."""
        action = self._known_finder().find_action(type_name, used_by)
        if problem := problem_here() or self_test_problem():
            raise TypeMissing(type_name, used_by, problem)
        # Commands fill the goal itself, and not the request that it is sent with.
        goal = TypeDefinition(f"{type_name}_Goal", action.send_goal.request.parts)
        return _shape_of_part(goal, f"{type_name}.action")

    def _known_finder(self) -> DefinitionFinder:
        if self._finder is None:
            self._finder = DefinitionFinder(self._named)
        return self._finder


def _spoken(infos: Collection[Any]) -> str:
    """Give the hash that a topic's publishers tell; the greatest where they differ."""
    return max(map(hash_of, infos), default="")


def _installed_hash(type_name: str) -> str:
    """Give the hash of an installed type; empty if it is not installed."""
    try:
        definition = installed_definition(type_name)
    except BadDefinition:
        return ""
    return "" if definition is None else type_hash(definition)


def _shape_of_part(definition: TypeDefinition, file: str) -> ReadableFields:
    parts = DefinedParts(definition)
    return shape_of(
        kind=parts.kind_of_part(definition.name),
        type_name=file,
        find=parts.kind_named,
        message=MessageEncoder(definition).new_message(),
        comment_of=parts.comment_of,
    )


def goal_of(type_name: str, used_by: str, types: ProbedTypes) -> tuple[ReadableFields, str]:
    """Read what an action's goal holds, whether or not its type is installed."""
    try:
        class_of(type_name, used_by)
    except TypeMissing:
        try:
            return _without_lists(types.find_goal(type_name, used_by))
        except (TypeMissing, BadDefinition) as error:
            return ReadableFields((), ()), str(error)
    return asked_of(type_name, used_by, "Goal", ".action")


def request_of(type_name: str, used_by: str, types: ProbedTypes) -> tuple[ReadableFields, str]:
    """Read what a service's request holds, whether or not its type is installed."""
    try:
        class_of(type_name, used_by)
    except TypeMissing:
        try:
            return _without_lists(types.find_request(type_name, used_by))
        except (TypeMissing, BadDefinition) as error:
            return ReadableFields((), ()), str(error)
    return asked_of(type_name, used_by, "Request", ".srv")


def heard_message_of(
    type_name: str, topic: str, infos: Collection[Any], types: ProbedTypes
) -> tuple[ReadableFields, str]:
    """Read what a message holds that somebody listens to; lists in it cannot be filled."""
    try:
        found = types.find(type_name, topic, infos)
    except (TypeMissing, DefinitionMismatch, BadDefinition) as error:
        return ReadableFields((), ()), str(error)
    package, _, name = type_name.split("/")
    kind = found.find(f"{package}/{name}")
    if kind is None:
        return ReadableFields((), ()), f"what a {type_name} holds is not known here"
    try:
        # Lists of a fixed length have their elements in an empty message, too.
        message = class_of(type_name, topic)()
    except TypeMissing:
        message = None
    shape = shape_of(
        kind=kind,
        type_name=f"{package}/{name}",
        find=found.find,
        message=message,
        comment_of=found.comment_of,
    )
    return _without_lists(shape)


def asked_of(type_name: str, used_by: str, part: str, kind: str) -> tuple[ReadableFields, str]:
    """Read what a request or a goal holds; lists in it cannot be filled from a form."""
    try:
        asked = getattr(class_of(type_name, used_by), part)
    except TypeMissing as error:
        return ReadableFields((), ()), str(error)
    shape = shape_of(
        kind=kind_of(asked),
        type_name=f"{type_name}{kind}",
        find=kind_named,
        message=asked(),
        comment_of=comment_of,
    )
    return _without_lists(shape)


def _without_lists(shape: ReadableFields) -> tuple[ReadableFields, str]:
    lists = [field.split(":", 1)[0] for field in shape.left_out]
    fields = tuple(field for field in shape.fields if "[" not in field.path)
    problem = f"its request holds lists ({', '.join(lists)})" if lists else ""
    return ReadableFields(fields, shape.left_out), problem
