"""What is written for one rosbridge client: answers, status messages, frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.rosbridge.wanted_topics import fragment_size_of
from talaia.wire.frames import CommandPhase
from talaia.wire.rosbridge.codec import encode_rosbridge

if TYPE_CHECKING:
    from collections.abc import Mapping

    from starlette.websockets import WebSocket

    from talaia.wire.rosbridge import client_messages as said

__all__ = ["RosbridgeOutput"]

# A client is told what is at least as grave as it asks for.
_LEVELS = ("info", "warning", "error", "none")
# Of action_msgs/msg/GoalStatus.
_GOAL_STATUS = {CommandPhase.SUCCEEDED: 4, CommandPhase.CANCELLED: 5, CommandPhase.UNKNOWN: 0}
_ABORTED = 6


class RosbridgeOutput:
    """Writes to one client's socket; each method returns when there is room for more."""

    def __init__(self, socket: WebSocket) -> None:
        """Write to ``socket``, which is accepted."""
        self._socket = socket
        # Of the protocol: by default a client hears of errors alone.
        self._level = "error"
        # Fragments of two answers must not have one id.
        self._number = 0

    def set_level(self, level: str) -> None:
        """Tell from this level on; one that is not known changes nothing."""
        if level in _LEVELS:
            self._level = level

    async def send_frames(self, frames: list[str | bytes]) -> None:
        """Write frames of one message."""
        for frame in frames:
            if isinstance(frame, str):
                await self._socket.send_text(frame)
            else:
                await self._socket.send_bytes(frame)

    async def tell_status(self, level: str, text: str, message_id: str | int | None = None) -> None:
        """Send a status message, if the client wants to hear of its level."""
        if _LEVELS.index(level) >= _LEVELS.index(self._level):
            status = {"op": "status", "level": level, "msg": text}
            await self.send_answer(status if message_id is None else {**status, "id": message_id})

    async def send_response(self, asked: said.RosbridgeCall, values: object, *, good: bool) -> None:
        """Answer a call; of one that failed ``values`` is a sentence."""
        answer = {"op": "service_response", "service": asked.service, "values": values}
        await self.send_answer({**answer, "result": good}, asked)

    async def end_goal(self, asked: said.RosbridgeGoal, text: str, phase: CommandPhase) -> None:
        """Tell what has become of a goal."""
        good = phase is CommandPhase.SUCCEEDED
        # What failed is read as a text by roslibjs.
        values = {"success": True, "message": text} if good else f"{phase.value}: {text}"
        status = _GOAL_STATUS.get(phase, _ABORTED)
        answer = {"op": "action_result", "action": asked.action, "values": values}
        await self.send_answer({**answer, "status": status, "result": good}, asked)

    async def send_answer(
        self,
        message: Mapping[str, object],
        asked: said.RosbridgeCall | said.RosbridgeGoal | None = None,
    ) -> None:
        """Send a message, as an answer with the id and in the fragments that were asked for."""
        size = 0
        if asked is not None:
            size = fragment_size_of(asked.fragment_size)
            if asked.id is not None:
                message = {**message, "id": asked.id}
        self._number += 1
        number = f"answer:{self._number}"
        await self.send_frames(
            encode_rosbridge(message, fragment_size=size, fragment_id=number, cbor=False)
        )
