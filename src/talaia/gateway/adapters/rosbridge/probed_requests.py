"""What services and actions behind a rosbridge server take, as its rosapi describes it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.message_fields import RosMessageType, shape_of
from talaia.gateway.adapters.rosbridge.server_questions import texts_of
from talaia.model.discovery.probe_report import ActionFound, ServiceFound

if TYPE_CHECKING:
    from talaia.gateway.adapters.rosbridge.server_questions import ServerQuestions
    from talaia.model.discovery.probe_report import FieldFound

__all__ = ["ProbedRequests"]

# Each is two questions to the robot.
_MOST = 200
# What every node of either ROS has, and what carries ROS, actions and rosapi itself.
_PLUMBING_ENDINGS = ("/get_loggers", "/set_logger_level")
_PLUMBING_NAMES = ("/rosapi/", "/rosbridge_websocket/")
_PLUMBING_TYPES = (
    "rcl_interfaces/",
    "type_description_interfaces/",
    "lifecycle_msgs/",
    "action_msgs/",
    "roscpp/",
)


class ProbedRequests:
    """Asks one server for what can be asked of its robot, one after the other."""

    def __init__(self, questions: ServerQuestions, ros: int) -> None:
        """Ask by these questions; ``ros`` is the version behind the server."""
        self._questions = questions
        self._ros = ros

    async def find_services(self) -> tuple[ServiceFound, ...]:
        """Describe the services of the robot's nodes."""
        answer = await self._questions.ask_service("/rosapi/services")
        found: list[ServiceFound] = []
        for name in sorted(set(texts_of(answer, "services"))):
            if name.endswith(_PLUMBING_ENDINGS) or name.startswith(_PLUMBING_NAMES):
                continue
            said = await self._questions.ask_service("/rosapi/service_type", service=name)
            kind = _text(said, "type")
            if kind.startswith(_PLUMBING_TYPES) or "/_action/" in name or len(found) >= _MOST:
                continue
            # Its node may have left since it was listed.
            if "/" not in kind:
                found.append(ServiceFound(name, "", (), "it does not answer"))
                continue
            details = await self._questions.ask_service(
                "/rosapi/service_request_details", type=kind
            )
            found.append(
                ServiceFound(name, _long_name(kind, "srv"), *self._read_request(details, kind))
            )
        return tuple(found)

    async def find_actions(self) -> tuple[ActionFound, ...]:
        """Describe the actions of the robot's nodes."""
        answer = await self._questions.ask_service("/rosapi/action_servers")
        found: list[ActionFound] = []
        for name in sorted(set(texts_of(answer, "action_servers")))[:_MOST]:
            said = await self._questions.ask_service("/rosapi/action_type", action=name)
            kind = _text(said, "type")
            if "/" not in kind:
                # Older ones only list them.
                found.append(ActionFound(name, "", (), "this rosapi tells no types of actions"))
                continue
            details = await self._questions.ask_service("/rosapi/action_goal_details", type=kind)
            found.append(
                ActionFound(name, _long_name(kind, "action"), *self._read_request(details, kind))
            )
        return tuple(found)

    def _read_request(self, details: object, kind: str) -> tuple[tuple[FieldFound, ...], str]:
        """Read what a request or a goal holds; lists in it cannot be filled from a form."""
        parts = [
            (str(getattr(part, "type", "")), _message_type(part))
            for part in getattr(details, "typedefs", None) or []
        ]
        if not parts:
            # A request of nothing has no definition in ROS 1's rosapi.
            return (), details if isinstance(details, str) else ""
        # The request itself, and then the types of its fields.
        first, request = parts[0]
        shape = shape_of(kind=request, type_name=first or kind, find=dict(parts).get)
        lists = [field.split(":", 1)[0] for field in shape.left_out]
        fields = tuple(field for field in shape.fields if "[" not in field.path)
        return fields, f"its request holds lists ({', '.join(lists)})" if lists else ""


def _message_type(part: object) -> RosMessageType:
    """Read one of rosapi's definitions; what does not fit together is left out."""
    lengths = getattr(part, "fieldarraylen", None)
    lengths = lengths if isinstance(lengths, list) else []
    named = zip(texts_of(part, "fieldnames"), texts_of(part, "fieldtypes"), lengths, strict=False)
    fields = tuple(
        (name, _declared(kind, length)) for name, kind, length in named if isinstance(length, int)
    )
    return RosMessageType(fields, {})


def _declared(kind: str, length: int) -> str:
    """Write a type as ROS 2 does; rosapi has the length beside it, and -1 for no list."""
    kind = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}.get(
        kind, kind
    )
    if length < 0:
        return kind
    return f"{kind}[{length}]" if length else f"sequence<{kind}>"


# Of an answer nothing is sure: it comes from another machine, of any version.
def _text(answer: object, name: str) -> str:
    found = getattr(answer, name, "")
    return found if isinstance(found, str) else ""


def _long_name(kind: str, middle: str) -> str:
    package, _, rest = kind.partition("/")
    return kind if "/" in rest else f"{package}/{middle}/{rest}"
