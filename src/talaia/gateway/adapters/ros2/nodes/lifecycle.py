"""Life-cycle nodes of ROS 2: their states as signals, their transitions as commands.

A state is told by the node's ``transition_event`` and asked for once a second, for what was missed.
On the wait-set thread.
"""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message

from talaia.gateway.adapters.ros2.nodes.node_readings import NodeReadings
from talaia.gateway.adapters.ros2.nodes.service_calls import ServiceCalls
from talaia.gateway.adapters.topic_readers import lifecycle_plans_of
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import CommandOutcome
from talaia.model.connections.ros import LIFECYCLE_TRANSITIONS, TRANSITION
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.topic_readers import TopicPlan
    from talaia.wire.frames import Scalar

__all__ = ["LifecycleStates", "LifecycleTransition"]

# Events that wait between two turns of the wait set.
_DEPTH = 20
# The state that a transition leads to when the node does it.
_LEADS_TO = {
    "configure": "inactive",
    "activate": "active",
    "deactivate": "inactive",
    "cleanup": "unconfigured",
    "shutdown": "finalized",
}


class _Watched(NamedTuple):
    """A node whose state is read."""

    calls: ServiceCalls  # Of ``get_state``.
    subscription: Any  # Of ``transition_event``.
    plans: list[TopicPlan]  # Emptied and filled anew with another description.


class LifecycleStates(NodeReadings[_Watched]):
    """The states that signals are made of."""

    def redescribe(self, scope: ConnectionScope) -> None:
        """Read the states of this scope; nodes that are watched already stay so."""
        before = {plan.channel: plan for plan in self.plans}
        self.plans = lifecycle_plans_of(scope, self._latest, self._complain)
        for name in self._nodes.keys() - {plan.topic for plan in self.plans}:
            watched = self._nodes.pop(name)
            watched.calls.close()
            self._thread.remove_subscription(watched.subscription.handle)
            self._node.destroy_subscription(watched.subscription)
        # Answers that are under way find the new plans.
        for watched in self._nodes.values():
            watched.plans.clear()
        for plan in self.plans:
            # What was held back goes on, and what was told of is not told again.
            if (was := before.get(plan.channel)) is not None:
                plan.take_over(was)
            if plan.topic not in self._nodes:
                self._nodes[plan.topic] = self._watch_node(plan.topic)
            self._nodes[plan.topic].plans.append(plan)

    def ask(self) -> None:
        """Ask every node that is there."""
        for watched in self._nodes.values():
            # Of one that is not there nobody would answer.
            if watched.calls.ready:
                on_state = partial(self._on_state, watched.plans)
                watched.calls.send(watched.calls.request(), on_state)

    def _watch_node(self, name: str) -> _Watched:
        plans: list[TopicPlan] = []

        def on_event(raw: bytes, _: Any) -> None:  # noqa: ANN401
            self._read_state(deserialize_message(raw, TransitionEvent).goal_state, plans)

        subscription = self._node.create_subscription(
            TransitionEvent, f"{name}/transition_event", _never, QoSProfile(depth=_DEPTH), raw=True
        )
        self._thread.add_subscription(subscription.handle, TransitionEvent, on_event)
        calls = ServiceCalls(self._node, GetState, f"{name}/get_state", self._thread)
        return _Watched(calls, subscription, plans)

    def _on_state(self, plans: list[TopicPlan], answer: Any) -> None:  # noqa: ANN401
        self._read_state(answer.current_state, plans)

    def _read_state(self, state: Any, plans: list[TopicPlan]) -> None:  # noqa: ANN401
        now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
        message = SimpleNamespace(data=state.label)
        for plan in plans:
            # What is on its way to a state (`activating`) is told only where it is described.
            if not plan.states or state.label in plan.states:
                plan.read_message(message, now_us, now_ns, self._gathered)


class LifecycleTransition:
    """One command that asks a node for a transition."""

    def __init__(self, target: str, node: Any, thread: WaitThread) -> None:  # noqa: ANN401
        """Make its clients."""
        self._target = target
        self._available = ServiceCalls(
            node, GetAvailableTransitions, f"{target}/get_available_transitions", thread
        )
        self._change = ServiceCalls(node, ChangeState, f"{target}/change_state", thread)
        self._state = ServiceCalls(node, GetState, f"{target}/get_state", thread)
        # Calls under way.
        self._open: list[Callable[[CommandOutcome], None]] = []

    @property
    def ready(self) -> bool:
        """Whether the node is there."""
        return self._change.ready and self._available.ready

    def close(self, outcome: CommandOutcome) -> None:
        """End its clients; what is under way ends as ``outcome``."""
        for calls in (self._available, self._change, self._state):
            calls.close()
        self.cut(outcome)

    def cut(self, outcome: CommandOutcome) -> None:
        """End what is under way as ``outcome``; the clients stay."""
        waiting, self._open = self._open, []
        for done in waiting:
            done(outcome)

    def act(self, fields: dict[str, Scalar], done: Callable[[CommandOutcome], None]) -> None:
        """Ask for a transition, if it leads on from the state that the node is in.

        Raises:
            FieldError: there is no such transition.

        """
        wanted = fields.get(TRANSITION)
        if not isinstance(wanted, str) or wanted not in LIFECYCLE_TRANSITIONS:
            words = ", ".join(LIFECYCLE_TRANSITIONS)
            raise FieldError(TRANSITION, f"{wanted!r} is no transition; one of {words}")
        if not self.ready:
            said = f"the robot has no life-cycle node {self._target} now"
            done(CommandOutcome(CommandPhase.REFUSED, said))
            return
        # From here on it may have to be told as *unknown*.
        self._open.append(done)

        def on_available(answer: Any) -> None:  # noqa: ANN401
            self._choose(wanted, answer.available_transitions, done)

        self._available.send(self._available.request(), on_available)

    def _choose(
        self, wanted: str, found: list[Any], done: Callable[[CommandOutcome], None]
    ) -> None:
        labels = {description.transition.label: description for description in found}
        if wanted not in labels:
            self._end(done, CommandPhase.REFUSED, _why_not(self._target, wanted, found))
            return
        request = self._change.request()
        # By its number: a node need not know the word.
        # Of several with one label (shutdown) the node says which is that of its state.
        request.transition = Transition(id=labels[wanted].transition.id, label=wanted)

        def on_changed(answer: Any) -> None:  # noqa: ANN401
            # The node says only whether; where it is then follows from the transition.
            if answer.success:
                said = f"{self._target} is {_LEADS_TO[wanted]} now"
                self._end(done, CommandPhase.SUCCEEDED, said)
            # After a failure it may be anywhere: it may have handled an error.
            else:
                self._state.send(self._state.request(), on_state)

        def on_state(answer: Any) -> None:  # noqa: ANN401
            state = answer.current_state.label
            said = f"{self._target} did not {wanted}: it is {state} now; its log may say why"
            self._end(done, CommandPhase.FAILED, said)

        self._change.send(request, on_changed)

    def _end(
        self, done: Callable[[CommandOutcome], None], phase: CommandPhase, message: str
    ) -> None:
        # It may have been told as *unknown* already.
        if done in self._open:
            self._open.remove(done)
            done(CommandOutcome(phase, message))


def _why_not(target: str, wanted: str, found: list[Any]) -> str:
    # They all begin at the state that the node is in.
    state = next((description.start_state.label for description in found), "")
    # Others are the node's own, of a transition that is under way.
    possible = [
        description.transition.label
        for description in found
        if description.transition.label in LIFECYCLE_TRANSITIONS
    ]
    if not possible:
        now = f"is {state}" if state else "has ended its life cycle"
        return f"{target} {now}: it cannot {wanted} now"
    can = ", ".join(possible)
    return f"{target} is {state}: it cannot {wanted} now, but {can}"


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
