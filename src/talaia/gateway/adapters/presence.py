"""Which devices of a ROS robot are there, of what is heard, offered and answered. Pure.

Neither graph tells of a process that was killed: ROS 2's keeps it until the middleware's lease is
over (20 s with Fast DDS), ROS 1's for good. And silence alone proves nothing: many a topic speaks
only when there is news. So nodes of a device that is silent are asked something that changes
nothing and that any node answers; who does not is gone, or hangs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import MS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

__all__ = ["LOOK_S", "Deafness", "DeviceEndpoints", "DevicePresence"]

# A look every quarter of a second, silence of at most 0.7 s until a node is asked, and four looks
# for its answer: less than the two seconds after which nothing old may look live.
LOOK_S = 0.25
ASK_NS = 450 * MS
# Looks are counted, not time: if this process stood still, the node is not to blame.
PATIENCE = 4
# Who has said anything in this time has been heard.
SPOKEN_NS = 1000 * MS


class DeviceEndpoints(NamedTuple):
    """What the graph shows of a device.

    Attributes:
        there: something of it is offered.
        nodes: who says its values; empty where nobody does, or where that cannot be told.
        askable: those of them that can be asked.
        nameless: something is offered by a node that has never told its name.

    """

    there: bool
    nodes: frozenset[str] = frozenset()
    askable: frozenset[str] = frozenset()
    nameless: bool = False


_NOTHING = DeviceEndpoints(there=False)


class DevicePresence:
    """Tells of each device that goes and that comes back. One thread."""

    def __init__(self, devices: Iterable[str], tell: Callable[[str, str, bool], None]) -> None:
        """Begin with nothing known: what was never there is not missed.

        Args:
            devices: of whom it is to be told.
            tell: told of each change: the device; why it is away, or nothing when it is back;
                and whether that is sure, or it may only be slow.

        """
        self._devices = tuple(devices)  # In the description's order.
        self._tell = tell
        self._seen: set[str] = set()  # Were there at least once since the start.
        # By device: why it is away; those that are there are not in it.
        self._away: dict[str, str] = {}
        self._answered_ns: dict[str, int] = {}  # By node: its last answer (monotonic ns).
        # By node: the look at which it was asked first without an answer since.
        self._open: dict[str, int] = {}
        self._gone: set[str] = set()  # Nodes that are dead for sure, until they speak or answer.
        self._look = 0  # The number of this look; patience is counted in it.
        self._deaf: bool | None = None  # See `deaf`.

    @property
    def deaf(self) -> bool | None:
        """Whether devices are there and none of them speaks or answers; none: not known yet."""
        return self._deaf

    def mark_alive(self, node: str, now_ns: int) -> None:
        """Take a node as alive."""
        self._answered_ns[node] = now_ns
        self._open.pop(node, None)
        self._gone.discard(node)

    def mark_dead(self, node: str) -> None:
        """Take a node as dead, without waiting: nobody is where it was."""
        self._gone.add(node)

    def judge_devices(
        self, now_ns: int, offers: Mapping[str, DeviceEndpoints], heard_ns: Mapping[str, int]
    ) -> frozenset[str]:
        """Judge every device.

        Args:
            now_ns: monotonic, as ``heard_ns`` and `mark_alive`.
            offers: by device.
            heard_ns: by device: when it said something last.

        Returns:
            The nodes to be asked now.

        """
        self._look += 1
        ask: set[str] = set()
        # Only those whose nodes are known can be asked, and so tell whether we are deaf.
        there = [device for device in self._devices if offers.get(device, _NOTHING).nodes]
        for device in self._devices:
            offer = offers.get(device, _NOTHING)
            if offer.there:
                self._seen.add(device)
            if device not in self._seen:
                continue
            # The graph itself says so: no patience is needed.
            if not offer.there:
                self._set_state(device, "nothing of it is on the robot now", sure=True)
            # It speaks, so its nodes live, whatever they owe an answer to.
            elif now_ns - heard_ns.get(device, 0) < ASK_NS:
                for node in offer.nodes:
                    self._open.pop(node, None)
                    self._gone.discard(node)
                self._set_state(device, "")
            else:
                self._set_state(device, self._silence_reason(offer, now_ns, ask))
        # The first question counts: one that is asked again has not been answered yet.
        for node in ask:
            self._open.setdefault(node, self._look)
        # 0: never heard, or never answered.
        words = [heard_ns.get(topic, 0) for topic in there]
        words += [self._answered_ns.get(node, 0) for topic in there for node in offers[topic].nodes]
        # Every ROS 2 node tells its name once to whoever joins, so who is silent and has no name
        # has never reached us, though the graph, which goes another way, shows its topics. Nobody
        # can ask it anything: without this, that would last for good.
        if there and all(
            topic in self._away
            or (offers[topic].nameless and now_ns - heard_ns.get(topic, 0) >= ASK_NS)
            for topic in there
        ):
            self._deaf = True
        elif any(now_ns - word < SPOKEN_NS for word in words if word):
            self._deaf = False
        else:
            self._deaf = None
        return frozenset(ask)

    def _silence_reason(self, offer: DeviceEndpoints, now_ns: int, ask: set[str]) -> str:
        # Also those that are asked already: an answer may be lost.
        ask |= {node for node in offer.askable if now_ns - self._answered_ns.get(node, 0) >= ASK_NS}
        # One node that lives is enough: the others may have nothing to say.
        if not offer.nodes or not all(self._is_dead(node) for node in offer.nodes):
            return ""
        return f"{', '.join(sorted(offer.nodes))} does not answer"

    def _is_dead(self, node: str) -> bool:
        return node in self._gone or self._look - self._open.get(node, self._look) >= PATIENCE

    def _set_state(self, device: str, why: str, *, sure: bool = False) -> None:
        # Told once for each change; another reason is a change, too.
        if why == self._away.get(device, ""):
            return
        if why:
            self._away[device] = why
        else:
            del self._away[device]
        self._tell(device, why, sure)


class Deafness:
    """When to join a robot anew because none of all that is there is heard.

    A middleware's transport may be broken on our side alone: Fast DDS's shared memory has been
    seen to deliver nothing any more to a process that had stood still for seconds, while the graph
    went on and requests arrived. A robot that hangs looks the same, so this is done seldom. It
    outlives each joining.
    """

    # In looks: longer than a graph keeps a robot that was killed (20 s with Fast DDS), and then
    # ever longer, up to 5 minutes.
    FIRST = round(22 / LOOK_S)
    LONGEST = round(300 / LOOK_S)

    def __init__(self) -> None:
        """Hear well."""
        self._looks = 0  # Looks in a row at which nobody was heard.
        self._limit = self.FIRST  # How many of them lead to joining anew; doubled each time.

    def should_rejoin(self, *, deaf: bool | None) -> bool:
        """Take in what `DevicePresence.deaf` says; tell whether to join anew now."""
        # Not known: neither counts nor calls the count off.
        if deaf is None:
            return False
        if not deaf:
            self._looks, self._limit = 0, self.FIRST
            return False
        self._looks += 1
        if self._looks < self._limit:
            return False
        self._looks, self._limit = 0, min(self.LONGEST, 2 * self._limit)
        return True
