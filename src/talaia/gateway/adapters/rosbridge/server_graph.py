"""What there is at a rosbridge server: its topics with their types, and its nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.ros2.type_definitions.message_definition import is_type_name
from talaia.gateway.adapters.rosbridge.server_questions import texts_of
from talaia.gateway.adapters.rosbridge.server_types import long_name
from talaia.gateway.tap_ports import GraphNode, ListedTopic
from talaia.model.topics import is_latched_by_convention

if TYPE_CHECKING:
    from talaia.gateway.adapters.rosbridge.server_questions import ServerQuestions

__all__ = ["TOPICS_SERVICE", "read_nodes", "read_topics"]

TOPICS_SERVICE = "/rosapi/topics"
# Each is a question to the robot.
_MAX_NODES = 200


async def read_topics(questions: ServerQuestions) -> dict[str, ListedTopic] | str:
    """Ask for all topics, by name; or give why there is no answer."""
    answer = await questions.ask_service(TOPICS_SERVICE)
    if isinstance(answer, str):
        return answer
    found = {}
    written = zip(texts_of(answer, "topics"), texts_of(answer, "types"), strict=False)
    for topic, short_type in written:
        type_name = long_name(short_type)
        if is_type_name(type_name):
            # A server does not say it.
            latched = is_latched_by_convention(topic, type_name)
            found[topic] = ListedTopic(topic, type_name, latched)
    return found


async def read_nodes(questions: ServerQuestions) -> list[GraphNode] | None:
    """Ask for all nodes, one after the other; None where rosapi does not say."""
    answer = await questions.ask_service("/rosapi/nodes")
    if isinstance(answer, str):
        return None
    found = []
    for name in sorted(filter(None, texts_of(answer, "nodes")))[:_MAX_NODES]:
        said = await questions.ask_service("/rosapi/node_details", node=name)
        # It may have left meanwhile.
        if not isinstance(said, str):
            names = (
                tuple(sorted(texts_of(said, kind)))
                for kind in ("publishing", "subscribing", "services")
            )
            found.append(GraphNode(name, *names))
    return found
