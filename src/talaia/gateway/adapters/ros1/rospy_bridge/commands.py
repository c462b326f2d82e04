"""One-shot commands: services, actions, messages and parameters.

Each call that is begun is told one final outcome under its number, on whatever thread it ends.
"""

# ruff: noqa: ANN401 - rospy ships no types
from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import rospy

from .message_paths import class_of, fill_message, message_class, number_at, service_class

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from .pipe_frames import FrameWriter
    from .topics import ZeroEndedPublisher

MAX_CALLS = 32
# How long a service or an action may take to be found (s).
_FIND_S = 0.5
# actionlib's terminal states (actionlib_msgs/GoalStatus); RECALLED (8) ended before it began.
_PHASES = {2: "cancelled", 3: "succeeded", 4: "failed", 5: "refused", 8: "cancelled"}


class CommandRunner:
    """All commands of one node."""

    def __init__(self, out: FrameWriter, publishers: dict[str, ZeroEndedPublisher]) -> None:
        """Take where outcomes go, and who publishes, by the command's name."""
        self._out = out
        self._publishers = publishers
        # By the command's name: proxy, type, and the service's own name.
        self._services: dict[str, tuple[Any, Any, str]] = {}
        # By the command's name: client, type of its goals, and what was asked.
        self._actions: dict[str, tuple[Any, Any, dict[str, Any]]] = {}
        # By the command's name: the call whose goal the action works on.
        self._goals: dict[str, int] = {}
        # Held while a goal is sent: see `cancel_goal`.
        self._sending = threading.RLock()
        # By the command's name: its type, which is not known on this machine.
        self._problems: dict[str, str] = {}
        self._calls = threading.Semaphore(MAX_CALLS)

    def prepare_command(self, asked: dict[str, Any], make: Callable[[], None]) -> None:
        """Get something ready for a command; its type may be missing here."""
        self._problems.pop(asked["id"], None)
        try:
            make()
        except (LookupError, ImportError, ValueError, AttributeError) as error:
            self._problems[asked["id"]] = asked["type"]
            name, about = asked.get("name", asked.get("topic", "")), {"type": asked["type"]}
            self._out.send_frame(
                op="missing", id=asked["id"], used_by=name, problem=str(error), **about
            )

    def prepare_service(self, asked: dict[str, Any]) -> None:
        """Get ready to call a service."""

        def make() -> None:
            kind = class_of(asked["type"], service_class)
            proxy = rospy.ServiceProxy(asked["name"], kind)
            self._services[asked["id"]] = (proxy, kind, asked["name"])

        self.prepare_command(asked, make)

    def prepare_action(self, asked: dict[str, Any]) -> None:
        """Get ready to send goals to an action."""

        def make() -> None:
            # Not on every machine with rospy, and needed only where there are actions.
            import actionlib  # type: ignore[import-not-found]

            package, middle, name = asked["type"].split("/")
            kind = class_of(package + "/" + middle + "/" + name + "Action", message_class)
            goal = class_of(package + "/" + middle + "/" + name + "Goal", message_class)
            client = actionlib.SimpleActionClient(asked["name"], kind)
            self._actions[asked["id"]] = (client, goal, asked)

        self.prepare_command(asked, make)

    def begin_command(self, asked: dict[str, Any]) -> None:
        """Begin a command; its end is told under its number."""
        name, call = asked["id"], asked["call"]
        if name in self._problems:
            self._report_outcome(
                call, "refused", f"its type {self._problems[name]} is not known here"
            )
        elif name in self._services:
            self._run_in_thread(call, lambda: self._call_service(name, call, asked["fields"]))
        elif name in self._actions:
            self._run_in_thread(call, lambda: self._send_goal(name, call, asked["fields"]))
        elif name in self._publishers:
            self._publish_message(name, call, asked["fields"])
        else:
            self._run_in_thread(call, lambda: self._set_parameters(call, asked))

    def cancel_goal(self, asked: dict[str, Any]) -> None:
        """End the goal of an action, if it is still this call's."""
        # The client knows the goal only after it has sent it; the robot may be faster.
        with self._sending:
            if self._goals.get(asked["id"]) == asked["call"]:
                self._actions[asked["id"]][0].cancel_goal()

    def _run_in_thread(self, call: int, work: Callable[[], None]) -> None:
        # rospy has no bound in time for a call, so each hangs in a thread of its own.
        if not self._calls.acquire(blocking=False):
            self._report_outcome(call, "refused", "too many calls wait for an answer")
            return

        def run() -> None:
            try:
                work()
            finally:
                self._calls.release()

        threading.Thread(target=run, daemon=True).start()

    def _report_outcome(
        self, call: int, phase: str, message: str = "", progress: float = 0.0
    ) -> None:
        self._out.send_frame(
            op="outcome", call=call, phase=phase, message=message, progress=progress
        )

    def _publish_message(self, name: str, call: int, fields: dict[str, Any]) -> None:
        publisher = self._publishers[name]
        try:
            # rospy would publish to nobody and be content.
            if publisher.publisher.get_num_connections() == 0:
                topic = publisher.publisher.name
                self._report_outcome(call, "refused", "nobody on the robot listens to " + topic)
                return
            publisher.publish_fields(fields)
        except (ValueError, rospy.ROSException, rospy.ROSSerializationException) as error:
            self._report_outcome(call, "refused", str(error))
            return
        self._report_outcome(call, "succeeded", "published")

    def _call_service(self, name: str, call: int, fields: dict[str, Any]) -> None:
        proxy, kind, service = self._services[name]
        try:
            request = fill_message(kind._request_class(), fields)  # noqa: SLF001 - genpy's own way
            rospy.wait_for_service(service, timeout=_FIND_S)
        except ValueError as error:
            self._report_outcome(call, "refused", str(error))
            return
        except rospy.ROSException:
            self._report_outcome(call, "refused", f"the robot does not offer {service} now")
            return
        try:
            response = proxy.call(request)
        except rospy.ServiceException as error:
            # One exception for all: refused by the server in its own words, never reached, or the
            # connection broke under way (then nobody knows). Only rospy's words tell them apart.
            words = str(error)
            phase = "unknown" if "transport error" in words else "failed"
            self._report_outcome(call, "refused" if "unable to connect" in words else phase, words)
        except (rospy.ROSException, rospy.ROSSerializationException) as error:
            self._report_outcome(call, "failed", str(error))
        else:
            # By the custom of std_srvs: `success` and `message`, where a response has them.
            words = getattr(response, "message", "")
            good = getattr(response, "success", True) is not False
            words = words if isinstance(words, str) else ""
            if not good and not words:
                words = "the robot says it did not succeed"
            self._report_outcome(call, "succeeded" if good else "failed", words)

    def _send_goal(self, name: str, call: int, fields: dict[str, Any]) -> None:
        client, kind, asked = self._actions[name]
        try:
            goal = fill_message(kind(), fields)
        except ValueError as error:
            self._report_outcome(call, "refused", str(error))
            return
        if not client.wait_for_server(rospy.Duration(_FIND_S)):
            self._report_outcome(call, "refused", f"the robot does not offer {asked['name']} now")
            return

        farthest = [0.0]

        def on_feedback(feedback: Any) -> None:
            progress = 0.0
            if asked["progress"]:
                try:
                    value, end = number_at(feedback, asked["progress"]), asked["progress_end"]
                    # With 0 for its end it counts down from the greatest that it said.
                    farthest[0] = max(farthest[0], value)
                    away = farthest[0] or 1.0
                    progress = value / end if end else (farthest[0] - value) / away
                except (AttributeError, IndexError, TypeError, ValueError):
                    # Feedback without the field is a sign of life all the same.
                    progress = 0.0
            self._report_outcome(call, "running", "", min(1.0, max(0.0, progress)))

        def on_done(state: int, result: Any) -> None:
            self._goals.pop(name, None)
            words = client.get_goal_status_text() or getattr(result, "message", "")
            message = words if isinstance(words, str) else ""
            self._report_outcome(call, _PHASES.get(state, "unknown"), message)

        with self._sending:
            # Before it is sent: its end may come on another thread at once.
            self._goals[name] = call
            client.send_goal(goal, done_cb=on_done, feedback_cb=on_feedback)

    def _set_parameters(self, call: int, asked: dict[str, Any]) -> None:
        try:
            for field, value in asked["fields"].items():
                rospy.set_param(asked["target"].rstrip("/") + "/" + field, value)
        except (OSError, rospy.ROSException) as error:
            # The master may have set some of them before it went.
            self._report_outcome(call, "unknown", str(error))
        except OverflowError as error:
            # XML-RPC has whole numbers of 32 bits.
            self._report_outcome(call, "failed", str(error))
        else:
            self._report_outcome(call, "succeeded", "set")
