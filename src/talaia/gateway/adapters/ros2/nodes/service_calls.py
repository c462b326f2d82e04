"""A ROS 2 service, and who waits for its answers. Used on the wait-set thread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.ports import CommandOutcome

__all__ = ["MAX_CALLS", "ServiceCalls"]

# Calls whose answer never came are forgotten beyond so many; their callers have long given up.
MAX_CALLS = 1000


class ServiceCalls:
    """One client and its calls that are under way."""

    def __init__(self, node: Any, kind: Any, name: str, thread: WaitThread) -> None:  # noqa: ANN401
        """Make the client."""
        self._node, self._thread = node, thread
        self._entity = node.create_client(kind, name)
        self._kind = kind
        # By the number of the request.
        self._pending: dict[int, Callable[[Any], None]] = {}
        thread.add_client(self._entity.handle, kind.Response, self._on_response)

    @property
    def ready(self) -> bool:
        """Whether somebody offers the service now."""
        return bool(self._entity.service_is_ready())

    def request(self) -> Any:  # noqa: ANN401
        """Give an empty request."""
        return self._kind.Request()

    def send(
        self,
        request: Any,  # noqa: ANN401
        answer: Callable[[Any], None],
        _failed: Callable[[CommandOutcome], None] | None = None,
    ) -> None:
        """Call; ``answer`` gets the response, if one comes; nothing is told if none does."""
        if len(self._pending) >= MAX_CALLS:
            self._pending.pop(next(iter(self._pending)))
        self._pending[self._entity.handle.send_request(request)] = answer

    def close(self) -> None:
        """End the client; nobody hears of what was under way."""
        self._thread.remove_client(self._entity.handle)
        self._node.destroy_client(self._entity)
        self._pending.clear()

    def _on_response(self, number: int, response: object) -> None:
        answer = self._pending.pop(number, None)
        if answer is not None:
            answer(response)
