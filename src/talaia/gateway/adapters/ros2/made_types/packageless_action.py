"""The form of an action whose type is not installed: its services are called by another process."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros2.actions import ActionForm
from talaia.gateway.adapters.ros2.made_types.packageless_calls import PackagelessCalls
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import decoder_of
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    type_hash,
)

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros2.made_types.packageless_services import PackagelessServices
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.type_definitions.service_definition import ServiceDefinition
    from talaia.model.site import Command

__all__ = ["PackagelessAction", "packageless_action"]


class PackagelessAction(NamedTuple):
    """An action's form, and the type and hash of its feedback."""

    form: ActionForm
    feedback: str
    feedback_hash: str


def packageless_action(
    command: Command,
    node: Any,  # noqa: ANN401 - rclpy ships no types
    thread: WaitThread,
    carrier: PackagelessServices,
) -> PackagelessAction | None:
    """Give how an action is used whose definition is in files; none where it is not. Reads them."""
    known = carrier.find_action(command.type)
    if known is None:
        return None
    found, hashes = known

    def calls(ending: str, service: ServiceDefinition, timeout_s: float | None) -> PackagelessCalls:
        return PackagelessCalls(
            service=f"{command.target}/_action/{ending}",
            definition=service,
            type_hash=hashes[service.name],
            node=node,
            thread=thread,
            carrier=carrier,
            timeout_s=timeout_s,
        )

    try:
        form = ActionForm(
            calls("send_goal", found.send_goal, command.timeout),
            # A goal takes as long as it takes.
            calls("get_result", found.get_result, None),
            decoder_of(found.feedback, proven=False),
        )
    except BadDefinition:
        return None
    return PackagelessAction(form, found.feedback.name, type_hash(found.feedback))
