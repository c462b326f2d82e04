"""Subscriptions of one ROS 2 node, each as its publishers offer it. On the wait-set thread.

A topic that is wanted is subscribed when somebody publishes it, and anew when a publisher comes
that the subscription would not hear.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Protocol

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, is_made
from talaia.gateway.adapters.ros2.qos import QosProfile, fits, quality_for
from talaia.gateway.adapters.ros2.type_definitions.robot_questions import hash_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, KeysView

    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread

__all__ = ["Ros2Subscriptions", "TopicReader"]

# A publisher that begins anew counts from 1 again: who publishes is looked at then, but where
# several publishers' numbers alternate no more often than this.
_LOOK_AGAIN_S = 0.25


class TopicReader(Protocol):
    """Reads the messages of one topic."""

    def set_publishers(self, hashes: frozenset[str]) -> None:
        """Take the hashes of the type that its publishers tell; told before their messages."""
        ...

    def read_message(self, raw: bytes, info: Any) -> None:  # noqa: ANN401 - rclpy ships no types
        """Take a message with rclpy's info of it."""
        ...


class _WantedTopic:
    """A topic that is wanted: its type, who reads its messages, and the subscription, if any."""

    def __init__(
        self, topic: str, type_name: str, reader: TopicReader, *, depth: int, large: bool
    ) -> None:
        self.topic = topic
        self.type_name = type_name
        # How many messages wait at most between two turns of the wait set.
        self.depth = depth
        # Its messages are read as views, see `WaitThread.add_subscription`.
        self.large = large
        # May be replaced while the subscription stays, see `Ros2Subscriptions.want`.
        self.reader = reader
        # What was asked for with the subscription; None while there is none.
        self.quality: QosProfile | None = None
        self.subscription: Any = None
        # Of the type, as its publishers tell it; None before there are any.
        self.hashes: frozenset[str] | None = None
        # The number that its publisher gave the last message, and when that was last doubted.
        self.number = 0
        self.looked_s = 0.0


class Ros2Subscriptions:
    """What is wanted, by a key of the caller's, and the subscriptions for it."""

    def __init__(
        self,
        node: Any,  # noqa: ANN401
        thread: WaitThread,
        find_class: Callable[[str, str, str], Any],
        complain: Callable[[str, str], None],
    ) -> None:
        """Take the node that subscribes and the thread that reads.

        Args:
            node: of rclpy.
            thread: see above.
            find_class: gives a message's class by its type, its topic and its publisher's hash;
                none if there is none, now or at all.
            complain: told of a topic that cannot be subscribed, and why; again and again.

        """
        self._node = node
        self._thread = thread
        self._find_class = find_class
        self._complain = complain
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
        type_name: str,
        *,
        depth: int,
        reader: TopicReader,
        large: bool = False,
    ) -> None:
        """Want a topic; one that is wanted already keeps its subscription and changes its reader.

        Args:
            key: the caller's.
            topic: absolute.
            type_name: ``package/msg/Name``.
            depth: messages that wait at most.
            reader: called on the wait-set thread.
            large: messages of megabytes, which the reader takes as views.

        """
        found = self._wanted.get(key)
        if found is None:
            self._wanted[key] = _WantedTopic(topic, type_name, reader, depth=depth, large=large)
            return
        found.reader = reader
        if found.hashes is not None:
            reader.set_publishers(found.hashes)

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
            if wanted is None or (wanted.subscription is None and wanted.hashes is not None):
                topic = key.split(" ", 1)[0] if wanted is None else wanted.topic
                unheard.append(f"{topic} (its type is not known here)")
            elif wanted.subscription is None:
                unheard.append(f"{wanted.topic} (nobody publishes it)")
        return unheard

    def _match(self, wanted: _WantedTopic) -> None:
        infos = self._node.get_publishers_info_by_topic(wanted.topic)
        offers = [
            QosProfile(
                info.qos_profile.reliability != ReliabilityPolicy.BEST_EFFORT,
                info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
            )
            for info in infos
        ]
        self._compare_hashes(wanted, infos)
        # Before anybody publishes there is nothing to match, and a wrong guess would have to be
        # changed just when the first messages come. It also means that the publisher is known
        # when its reader is made, so that a reliable one's first words are not thrown away.
        if not offers or (wanted.quality is not None and fits(wanted.quality, offers)):
            return
        self._unsubscribe(wanted)
        if not wanted.hashes:
            spoken = " and ".join(sorted({info.topic_type for info in infos}))
            problem = f"it is published as {spoken}, and the description says {wanted.type_name}"
            self._complain(wanted.topic, problem)
            return
        spoken = max(wanted.hashes)
        kind = self._find_class(wanted.type_name, wanted.topic, spoken)
        if kind is not None:
            self._subscribe(wanted, kind, quality_for(offers))

    def _compare_hashes(self, wanted: _WantedTopic, infos: Collection[Any]) -> None:
        """Tell the reader which versions of its type are published, if they are others now."""
        hashes = frozenset(hash_of(info) for info in infos if info.topic_type == wanted.type_name)
        # While nobody publishes it, the last ones count.
        if hashes and hashes != wanted.hashes:
            wanted.hashes = hashes
            wanted.reader.set_publishers(hashes)

    def _subscribe(self, wanted: _WantedTopic, kind: Any, quality: QosProfile) -> None:  # noqa: ANN401
        profile = QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=wanted.depth,
            reliability=ReliabilityPolicy.RELIABLE
            if quality.reliable
            else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL
            if quality.latched
            else DurabilityPolicy.VOLATILE,
        )
        try:
            wanted.subscription = self._node.create_subscription(
                kind, wanted.topic, _never, profile, raw=True
            )
        except RuntimeError as error:
            # One process cannot have two types of one topic; tried again when others have ended.
            self._complain(wanted.topic, f"cannot be heard as {wanted.type_name}: {error}")
            return
        finally:
            if is_made(kind):
                forget_error()
        wanted.quality = quality

        def read_message(raw: bytes, info: Any) -> None:  # noqa: ANN401
            number = info.get("publication_sequence_number") or 0
            if number <= wanted.number:
                self._look_again(wanted)
            wanted.number = number
            wanted.reader.read_message(raw, info)

        self._thread.add_subscription(
            wanted.subscription.handle, kind, read_message, large=wanted.large
        )

    def _look_again(self, wanted: _WantedTopic) -> None:
        """See who publishes now, before a message is read as what the last publisher spoke."""
        now_s = time.monotonic()
        if now_s - wanted.looked_s >= _LOOK_AGAIN_S:
            wanted.looked_s = now_s
            infos = self._node.get_publishers_info_by_topic(wanted.topic)
            self._compare_hashes(wanted, infos)

    def _unsubscribe(self, wanted: _WantedTopic) -> None:
        if wanted.subscription is not None:
            self._thread.remove_subscription(wanted.subscription.handle)
            self._node.destroy_subscription(wanted.subscription)
        wanted.subscription, wanted.quality = None, None


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
