"""Nodes as rosapi names them: our devices, and the robot's own that one may see. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.hub.clients.rosbridge.offer import RosbridgeOffer
    from talaia.wire.frames import RobotGraph

__all__ = ["NODE_QUESTIONS", "NodeNames"]

NODE_QUESTIONS = frozenset(
    {"nodes", "node_details", "publishers", "subscribers", "service_node", "service_providers"}
)
# The site as a whole: it publishes raw topics of which the robot does not say who does.
_SITE = "/talaia"
# By node: what it has.
_Names = dict[str, list[str]]


class NodeNames(NamedTuple):
    """What a client may see at this moment.

    Attributes:
        topics: all of them, with their types.
        tapped: those of them that are the robot's own.
        offer: what is offered beside them.
        robot: the robot's nodes.

    """

    topics: Mapping[str, str]
    tapped: frozenset[str]
    offer: RosbridgeOffer
    robot: RobotGraph

    def answer_question(self, service: str, name: str) -> dict[str, object]:
        """Answer one of `NODE_QUESTIONS`."""
        match service:
            case "publishers":
                return {"publishers": _owners_of(self._published(), name)}
            case "subscribers":
                return {"subscribers": _owners_of(self._subscribed(), name)}
            case "service_node":
                return {"node": next(iter(_owners_of(self._served(), name)), "")}
            case "service_providers":
                # By the service's type.
                named = [said for said, of in self.offer.services.items() if of.type == name]
                served = self._served()
                found = dict.fromkeys(node for said in named for node in _owners_of(served, said))
                return {"providers": list(found)}
            case "nodes":
                owners = (self._published(), self._subscribed(), self._served())
                return {"nodes": list(dict.fromkeys([_SITE, *(n for of in owners for n in of)]))}
            case _:
                return {
                    "subscribing": self._subscribed().get(name, []),
                    "publishing": self._published().get(name, []),
                    "services": self._served().get(name, []),
                }

    def _published(self) -> _Names:
        offer = self.offer
        found = _listed((node.name, node.publishes) for node in self.robot.nodes)
        known = {topic for topics in found.values() for topic in topics}
        for topic in self.topics:
            signal = offer.signals.get(topic)
            if signal is not None:
                found.setdefault(signal.node, []).append(topic)
            elif topic in self.tapped and topic not in known:
                found.setdefault(_SITE, []).append(topic)
        return found

    def _subscribed(self) -> _Names:
        found = _listed((node.name, node.subscribes) for node in self.robot.nodes)
        devices = {topic: robot.device for topic, robot in self.offer.listened.items()}
        devices |= {topic: driven.device for topic, driven in self.offer.driven.items()}
        for topic, device in devices.items():
            # First: it is what listens here.
            found = {f"{_SITE}/{device}": [], **found}
            found[f"{_SITE}/{device}"].append(topic)
        return found

    def _served(self) -> _Names:
        found = _listed((node.name, node.serves) for node in self.robot.nodes)
        known = {service for services in found.values() for service in services}
        for name, offered in self.offer.services.items():
            if name not in known:
                found.setdefault(offered.node, []).append(name)
        return found


def _listed(nodes: Iterable[tuple[str, list[str]]]) -> _Names:
    return {node: list(names) for node, names in nodes if names}


def _owners_of(names: _Names, name: str) -> list[str]:
    return [node for node, owned in names.items() if name in owned]
