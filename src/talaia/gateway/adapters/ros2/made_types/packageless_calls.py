"""One service of a type that is not installed, as `ServiceCalls` are; on the wait-set thread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from talaia.gateway.adapters.ros2.made_types.packageless_services import CarriedRequest
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import decoder_of
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.made_types.packageless_services import PackagelessServices
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.type_definitions.service_definition import ServiceDefinition
    from talaia.gateway.ports import CommandOutcome

__all__ = ["PackagelessCalls"]


class PackagelessCalls:
    """Calls that are carried by a process of their own; see `PackagelessServices`."""

    def __init__(
        self,
        *,
        service: str,
        definition: ServiceDefinition,
        type_hash: str,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        carrier: PackagelessServices,
        timeout_s: float | None,
    ) -> None:
        """Take what is called.

        Args:
            service: its name.
            definition: of its type.
            type_hash: by which its node confirms the version.
            node: knows the graph.
            thread: answers are told there.
            carrier: calls.
            timeout_s: an answer takes no longer; none where it may take for ever.

        Raises:
            BadDefinition: it cannot be written here.

        """
        self._service, self._type_name, self._type_hash = service, definition.name, type_hash
        self._node, self._thread, self._carrier = node, thread, carrier
        self._timeout_s = timeout_s
        self._encoder = MessageEncoder(definition.request)
        self._read = decoder_of(definition.response, proven=True)

    @property
    def ready(self) -> bool:
        """Whether somebody offers the service now."""
        return any(name == self._service for name, _ in self._node.get_service_names_and_types())

    def request(self) -> Any:  # noqa: ANN401
        """Give an empty request."""
        return self._encoder.new_message()

    def send(
        self,
        request: Any,  # noqa: ANN401
        answer: Callable[[Any], None],
        failed: Callable[[CommandOutcome], None],
    ) -> None:
        """Call; one of the two is told, once.

        Raises:
            FieldError: a value does not fit its field.

        """
        soon = self._thread.run_soon
        self._carrier.carry_request(
            CarriedRequest(
                self._service,
                self._type_name,
                self._type_hash,
                self._encoder.encode_message(request),
                self._timeout_s,
            ),
            self._read,
            # They come on the thread that reads what the process says.
            lambda message: soon(lambda: answer(message)),
            lambda outcome: soon(lambda: failed(outcome)),
        )

    def close(self) -> None:
        """End nothing: the process is all services'."""
