"""Subscriptions of one ROS 2 node, each as its publishers offer it. On the wait-set thread.

A topic that is wanted is subscribed when somebody publishes it, and anew when a publisher comes
that the subscription would not hear.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from talaia.gateway.adapters.ros2.qos import QosProfile, fits, quality_for

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, KeysView

    from talaia.gateway.adapters.ros2.waitset import WaitThread

__all__ = ["Ros2Subscriptions"]


class _WantedTopic:
    """A topic that is wanted: its class, who reads its messages, and the subscription, if any."""

    def __init__(
        self,
        topic: str,
        kind: Any,  # noqa: ANN401 - rclpy ships no types
        depth: int,
        read: Callable[[bytes, Any], None],
    ) -> None:
        self.topic = topic
        # The message's Python class.
        self.kind = kind
        # How many messages wait at most between two turns of the wait set.
        self.depth = depth
        # May be replaced while the subscription stays, see `Ros2Subscriptions.want`.
        self.read = read
        # What was asked for with the subscription; None while there is none.
        self.quality: QosProfile | None = None
        self.subscription: Any = None

    def read_message(self, raw: bytes, info: Any) -> None:  # noqa: ANN401
        """Hand a message to whoever reads them now."""
        self.read(raw, info)


class Ros2Subscriptions:
    """What is wanted, by a key of the caller's, and the subscriptions for it."""

    def __init__(self, node: Any, thread: WaitThread) -> None:  # noqa: ANN401
        """Take the node that subscribes and the thread that reads."""
        self._node = node
        self._thread = thread
        self._wanted: dict[str, _WantedTopic] = {}

    @property
    def wanted(self) -> KeysView[str]:
        """The keys of what is wanted."""
        return self._wanted.keys()

    def topics(self, *, without: tuple[str, ...] = ()) -> set[str]:
        """Give the topics that are wanted under keys that do not begin with any of these."""
        return {wanted.topic for key, wanted in self._wanted.items() if not key.startswith(without)}

    def want(
        self,
        key: str,
        topic: str,
        kind: Any,  # noqa: ANN401
        *,
        depth: int,
        read: Callable[[bytes, Any], None],
    ) -> None:
        """Want a topic; one that is wanted already keeps its subscription and changes its reader.

        Args:
            key: the caller's.
            topic: absolute.
            kind: the message's class.
            depth: messages that wait at most.
            read: called on the wait-set thread with each message's bytes and rclpy's info.

        """
        found = self._wanted.get(key)
        if found is None:
            self._wanted[key] = _WantedTopic(topic, kind, depth, read)
        else:
            found.read = read

    def unwant(self, key: str) -> None:
        """Want a topic no more."""
        wanted = self._wanted.pop(key, None)
        if wanted is not None:
            self._unsubscribe(wanted)

    def unsubscribe(self, keys: Collection[str]) -> None:
        """End subscriptions of topics that stay wanted: the next `match_publishers` begins anew."""
        for key in keys & self._wanted.keys():
            self._unsubscribe(self._wanted[key])

    def match_publishers(self, *, everything: bool) -> None:
        """Bring subscriptions in line with what publishers offer.

        Args:
            everything: also look at those that are subscribed, which costs more.

        """
        for wanted in self._wanted.values():
            if everything or wanted.subscription is None:
                self._match(wanted)

    def offered_type(self, topic: str) -> str | None:
        """Give the type of the first publisher of a topic; None while nobody publishes it."""
        offered = self._node.get_publishers_info_by_topic(topic)
        return offered[0].topic_type if offered else None

    def name_unheard(self, keys: Collection[str]) -> list[str]:
        """Name the topics that nobody publishes now, and types not known here."""
        unheard = []
        for key in keys:
            wanted = self._wanted.get(key)
            if wanted is None:
                unheard.append(f"{key.split(' ', 1)[0]} (its type is not known here)")
            elif wanted.subscription is None:
                unheard.append(f"{wanted.topic} (nobody publishes it)")
        return unheard

    def _match(self, wanted: _WantedTopic) -> None:
        offers = [
            QosProfile(
                info.qos_profile.reliability != ReliabilityPolicy.BEST_EFFORT,
                info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
            )
            for info in self._node.get_publishers_info_by_topic(wanted.topic)
        ]
        # Before anybody publishes there is nothing to match, and a wrong guess would have to be
        # changed just when the first messages come. It also means that the publisher is known
        # when its reader is made, so that a reliable one's first words are not thrown away.
        if not offers or (wanted.quality is not None and fits(wanted.quality, offers)):
            return
        self._unsubscribe(wanted)
        wanted.quality = quality_for(offers)
        profile = QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=wanted.depth,
            reliability=ReliabilityPolicy.RELIABLE
            if wanted.quality.reliable
            else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL
            if wanted.quality.latched
            else DurabilityPolicy.VOLATILE,
        )
        wanted.subscription = self._node.create_subscription(
            wanted.kind, wanted.topic, _never, profile, raw=True
        )
        self._thread.add_subscription(wanted.subscription.handle, wanted.kind, wanted.read_message)

    def _unsubscribe(self, wanted: _WantedTopic) -> None:
        if wanted.subscription is not None:
            self._thread.remove_subscription(wanted.subscription.handle)
            self._node.destroy_subscription(wanted.subscription)
        wanted.subscription, wanted.quality = None, None


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
