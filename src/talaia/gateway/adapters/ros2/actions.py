"""Commands as ROS 2 actions: goal, feedback, result and cancel. Used on the wait-set thread.

An action is three services and a topic (REP-2: ``<name>/_action/send_goal``, ``get_result``,
``cancel_goal`` and ``feedback``). They are used as such, because rclpy's own action client needs
one of rclpy's executors, and `WaitThread` is none.
"""

from __future__ import annotations

import contextlib
import uuid
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message

from talaia.gateway.adapters.ros2.nodes.service_calls import ServiceCalls
from talaia.gateway.adapters.ros2.requests import fill, outcome_of
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.samples.action_progress import ActionProgress
from talaia.gateway.samples.field_paths import compile_getter
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.made_types.packageless_calls import PackagelessCalls
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.model.site import Command
    from talaia.wire.frames import Scalar

__all__ = ["ActionForm", "ActionGoal", "Ros2Action", "installed_form"]

FEEDBACK_DEPTH = 10
# Goals whose end never came are forgotten beyond so many; their callers have long given up.
MAX_GOALS = 1000


class ActionGoal:
    """One goal of ours."""

    def __init__(self, done: Callable[[CommandOutcome], None], progress_end: float = 1.0) -> None:
        """Give it a name that nobody else has."""
        self.id = uuid.uuid4()
        self.done = done
        self.accepted = False
        self.unwanted = False
        self.progress = ActionProgress(progress_end)


class ActionForm(NamedTuple):
    """How the messages of one action are written and read, installed or not.

    Attributes:
        send: calls ``send_goal``.
        result: calls ``get_result``.
        read: gives a feedback message's fields; raises `FieldError` for what is no such message.

    """

    send: ServiceCalls | PackagelessCalls
    result: ServiceCalls | PackagelessCalls
    read: Callable[[bytes], Any]


def installed_form(command: Command, kind: Any, node: Any, thread: WaitThread) -> ActionForm:  # noqa: ANN401
    """Give the form of an action whose class is installed."""
    name = f"{command.target}/_action"
    message = kind.Impl.FeedbackMessage
    return ActionForm(
        ServiceCalls(node, kind.Impl.SendGoalService, f"{name}/send_goal", thread),
        ServiceCalls(node, kind.Impl.GetResultService, f"{name}/get_result", thread),
        lambda raw: deserialize_message(raw, message),
    )


class Ros2Action:
    """One command that is an action.

    Attributes:
        progress_end: see `ActionProgress`.

    """

    def __init__(self, command: Command, form: ActionForm, node: Any, thread: WaitThread) -> None:  # noqa: ANN401
        """Make its other client; feedback is heard from `hear_feedback` on."""
        self._command, self._node, self._thread = command, node, thread
        self._goals: dict[bytes, ActionGoal] = {}
        self._send, self._result, self._read = form
        self._cancel = ServiceCalls(
            node, CancelGoal, f"{command.target}/_action/cancel_goal", thread
        )
        self.progress_end = command.progress_end
        self._progress = compile_getter(command.progress) if command.progress else None
        # None until it is heard, and for good where it cannot be.
        self._subscription: Any = None
        self._closed = False

    def hear_feedback(self, message: Any) -> None:  # noqa: ANN401
        """Hear feedback, by the class of its messages."""
        if self._closed:
            return

        def on_feedback(raw: bytes, _: Any) -> None:  # noqa: ANN401
            # What cannot be read tells no progress; the goal goes on.
            with contextlib.suppress(FieldError):
                self._feedback(self._read(raw))

        # Kept, because a subscription that nobody holds is destroyed.
        self._subscription = self._node.create_subscription(
            message,
            f"{self._command.target}/_action/feedback",
            _never,
            QoSProfile(depth=FEEDBACK_DEPTH),
            raw=True,
        )
        self._thread.add_subscription(self._subscription.handle, message, on_feedback)

    @property
    def ready(self) -> bool:
        """Whether the robot offers it now."""
        return self._send.ready

    def close(self, outcome: CommandOutcome) -> None:
        """End its clients; goals under way end as ``outcome``."""
        for calls in (self._send, self._result, self._cancel):
            calls.close()
        self._closed = True
        if self._subscription is not None:
            self._thread.remove_subscription(self._subscription.handle)
            self._node.destroy_subscription(self._subscription)
        self.cut(outcome)

    def cut(self, outcome: CommandOutcome) -> None:
        """End goals under way as ``outcome``; the clients stay."""
        goals, self._goals = list(self._goals.values()), {}
        for goal in goals:
            goal.done(outcome)

    def act(self, goal: ActionGoal, fields: dict[str, Scalar]) -> None:
        """Send a goal.

        Raises:
            FieldError: a field that the goal does not have, or a value that does not fit it.

        """
        request = self._send.request()
        fill(request.goal, fields)
        request.goal_id.uuid = _uuid_of(goal)
        if not self._send.ready:
            target = self._command.target
            goal.done(
                CommandOutcome(CommandPhase.REFUSED, f"the robot does not offer {target} now")
            )
            return
        if len(self._goals) >= MAX_GOALS:
            self._goals.pop(next(iter(self._goals)))
        self._goals[goal.id.bytes] = goal
        self._send.send(
            request,
            lambda answer: self._answered(goal, answer),
            lambda outcome: self._fail(goal, outcome),
        )

    def cancel(self, goal: ActionGoal) -> None:
        """Ask the robot to end a goal; what becomes of it is told as its result."""
        goal.unwanted = True
        if not goal.accepted or goal.id.bytes not in self._goals:
            # It is asked for as soon as the robot has accepted it; if it ended, there is no need.
            return
        request = self._cancel.request()
        request.goal_info.goal_id.uuid = _uuid_of(goal)

        def answered(answer: Any) -> None:  # noqa: ANN401
            if answer.return_code != CancelGoal.Response.ERROR_NONE:
                goal.done(CommandOutcome(CommandPhase.RUNNING, "the robot does not cancel it"))

        self._cancel.send(request, answered)

    def _answered(self, goal: ActionGoal, answer: Any) -> None:  # noqa: ANN401
        if goal.id.bytes not in self._goals:
            # Its end was told already, as *unknown*.
            return
        if not answer.accepted:
            self._goals.pop(goal.id.bytes, None)
            goal.done(CommandOutcome(CommandPhase.REFUSED, "the robot does not accept it"))
            return
        goal.accepted = True
        request = self._result.request()
        request.goal_id.uuid = _uuid_of(goal)
        self._result.send(
            request,
            lambda result: self._ended(goal, result),
            # It was accepted: whatever came between says nothing of what became of it.
            lambda outcome: self._fail(goal, CommandOutcome(CommandPhase.UNKNOWN, outcome.message)),
        )
        if goal.unwanted:
            self.cancel(goal)

    def _fail(self, goal: ActionGoal, outcome: CommandOutcome) -> None:
        if self._goals.pop(goal.id.bytes, None) is not None:
            goal.done(outcome)

    def _feedback(self, message: Any) -> None:  # noqa: ANN401
        goal = self._goals.get(bytes(message.goal_id.uuid))
        if goal is None:
            return
        share = 0.0
        if self._progress is not None:
            try:
                value: Any = self._progress(message.feedback)
                share = goal.progress.share_of(float(value))
            except (FieldError, TypeError, ValueError):
                share = 0.0
        goal.done(CommandOutcome(CommandPhase.RUNNING, progress=share))

    def _ended(self, goal: ActionGoal, answer: Any) -> None:  # noqa: ANN401
        if self._goals.pop(goal.id.bytes, None) is None:
            return
        said = outcome_of(answer.result)
        match answer.status:
            case GoalStatus.STATUS_SUCCEEDED:
                goal.done(said)
            case GoalStatus.STATUS_CANCELED:
                goal.done(CommandOutcome(CommandPhase.CANCELLED, said.message))
            case GoalStatus.STATUS_ABORTED:
                goal.done(
                    CommandOutcome(CommandPhase.FAILED, said.message or "the robot gave it up")
                )
            case _:
                goal.done(CommandOutcome(CommandPhase.UNKNOWN, "the robot knows no more of it"))


def _uuid_of(goal: ActionGoal) -> Any:  # noqa: ANN401
    return np.frombuffer(goal.id.bytes, np.uint8)


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
