"""Types of a server's topics: how its messages of them are serialized, asked for once."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.rosbridge.robot_definitions import learn_type
from talaia.gateway.adapters.rosbridge.server_questions import texts_of

if TYPE_CHECKING:
    from talaia.gateway.adapters.rosbridge.robot_definitions import ServerType
    from talaia.gateway.adapters.rosbridge.server_questions import ServerQuestions

__all__ = ["RAW_TYPES_SERVICE", "ServerTypes", "long_name"]

RAW_TYPES_SERVICE = "/rosapi/topics_and_raw_types"
# Between two questions (s): the robot reads the files of all its types for one.
_AGAIN_S = 30.0


class ServerTypes:
    """All types of one connection. On the event loop."""

    def __init__(self, questions: ServerQuestions, ros: int) -> None:
        """Ask nothing yet; ``ros`` is the version behind the server."""
        self._questions = questions
        self._ros = ros
        # By type: what the robot says of it, and what was made of that.
        self._texts: dict[str, str] = {}
        self._known: dict[str, ServerType] = {}
        self._again = 0.0

    async def find_type(self, type_name: str) -> ServerType | str:
        """Give how a type is serialized, or why that is not known."""
        known = self._known.get(type_name)
        if known is not None:
            return known
        loop = asyncio.get_running_loop()
        if type_name not in self._texts and loop.time() >= self._again:
            self._again = loop.time() + _AGAIN_S
            answer = await self._questions.ask_service(RAW_TYPES_SERVICE)
            types = [long_name(name) for name in texts_of(answer, "types")]
            self._texts = dict(zip(types, texts_of(answer, "typedefs_full_text"), strict=False))
        # On another thread: it compiles code, and may read the definitions of a distribution.
        learn = partial(learn_type, type_name, self._texts.get(type_name, ""), self._ros)
        try:
            known = await loop.run_in_executor(None, learn)
        except BadDefinition as error:
            return str(error)
        self._known[type_name] = known
        return known


def long_name(written: str) -> str:
    """Give ``package/msg/Name``: ROS 1 knows no middle part, nor does rosapi's first on ROS 2."""
    package, _, rest = written.partition("/")
    return written if "/" in rest else f"{package}/msg/{rest}"
