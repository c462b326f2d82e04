"""Questions to a server's rosapi: services that only read."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.adapters.rosbridge.protocol import write_frame

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection

    from talaia.gateway.adapters.rosbridge.protocol import ServerMessage

__all__ = ["ServerQuestions", "texts_of"]

# So long for an answer (s).
_ANSWER_S = 10.0
_PREFIX = "ask "


class ServerQuestions:
    """Questions on one connection. On the event loop, one of a service at a time."""

    def __init__(self, socket: ClientConnection) -> None:
        """Ask on this connection; whoever reads it hands answers to `take_answer`."""
        self._socket = socket
        # By service.
        self._asked: dict[str, asyncio.Future[ServerMessage]] = {}

    async def ask_service(self, service: str, /, **args: str) -> object | str:
        """Give the values of a service's answer, or why there are none."""
        answer: asyncio.Future[ServerMessage] = asyncio.get_running_loop().create_future()
        self._asked[service] = answer
        frame = write_frame("call_service", id=f"{_PREFIX}{service}", service=service, args=args)
        await self._socket.send(frame)
        try:
            async with asyncio.timeout(_ANSWER_S):
                said = await answer
        except TimeoutError:
            return f"no answer within {_ANSWER_S:g} s"
        finally:
            self._asked.pop(service, None)
        # A server refuses a call by a status of its name, too.
        if said.op != "service_response" or not said.result:
            return f"{said.body!s:.300}"
        return said.body

    def take_answer(self, said: ServerMessage) -> None:
        """Take what may be an answer; one that nobody waits for changes nothing."""
        waiting = self._asked.pop(said.id.removeprefix(_PREFIX), None)
        if waiting is not None and not waiting.done():
            waiting.set_result(said)


def texts_of(values: object, name: str) -> list[str]:
    """Give a list of texts in an answer; what is none is an empty one."""
    found = getattr(values, name, None)
    if not isinstance(found, list):
        return []
    return [text if isinstance(text, str) else "" for text in found]
