"""Commands as ROS 2 service calls, publications, actions and transitions of nodes.

Long, because a device's commands of every kind are made, begun, cut and closed together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros2.actions import ActionGoal, Ros2Action, installed_form
from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error
from talaia.gateway.adapters.ros2.made_types.packageless_action import packageless_action
from talaia.gateway.adapters.ros2.made_types.packageless_publisher import PackagelessPublisher
from talaia.gateway.adapters.ros2.nodes.lifecycle import LifecycleTransition
from talaia.gateway.adapters.ros2.nodes.parameters import as_set, parameters_of
from talaia.gateway.adapters.ros2.requests import class_of, fill, outcome_of
from talaia.gateway.errors import FieldError, TypeMissing
from talaia.gateway.ports import CommandOutcome
from talaia.model.site import CommandKind
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros2.made_types.packageless_services import PackagelessServices
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.topic_types import TopicTypes
    from talaia.model.site import Command
    from talaia.wire.frames import Scalar

__all__ = ["Ros2Commands"]

# Calls that were never answered are forgotten beyond so many; their callers have long given up.
MAX_PENDING = 1000
_SET = "rcl_interfaces/srv/SetParameters"
_GONE = "it does not answer any more; look at the device to see what it did"
_CUT = "the connection was made anew meanwhile; look at the device to see what it did"


class _Client(NamedTuple):
    """A service client and the calls that wait for its answer, by request number."""

    entity: Any
    kind: Any
    pending: dict[int, Callable[[CommandOutcome], None]]


class Ros2Commands:
    """All commands of a site. Used on the wait-set thread, but for the making."""

    def __init__(
        self,
        *,
        scope: ConnectionScope,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        missing: Callable[[TypeMissing], None],
        packageless: PackagelessServices,
        types: TopicTypes,
    ) -> None:
        """Make a client or publisher for each command, so that they are known before they act."""
        # Calls services whose type has no package here; and the commands that go through it.
        self._packageless = packageless
        self._without_package: set[str] = set()
        # Finds the types of messages that are published without their package; and who does so.
        self._types = types
        self._bare_publishers: dict[str, PackagelessPublisher] = {}
        # What a command is made into, by its address: each address stands in one of these.
        self._scope, self._node, self._thread, self._missing = scope, node, thread, missing
        self._clients: dict[str, _Client] = {}
        self._publishers: dict[str, tuple[Any, Any]] = {}
        self._actions: dict[str, Ros2Action] = {}
        self._transitions: dict[str, LifecycleTransition] = {}
        # Why a command could not be made at all, as it is said to whoever gives it.
        self._problems: dict[str, str] = {}
        self._commands: dict[str, Command] = {}
        for device_id, device in scope.devices.items():
            for command_id, command in device.commands.items():
                self._make(f"{device_id}/{command_id}", command)

    def _make(self, address: str, command: Command) -> None:
        self._commands[address] = command
        if command.kind is CommandKind.LIFECYCLE:
            transition = LifecycleTransition(command.target, self._node, self._thread)
            self._transitions[address] = transition
            return
        sets = command.kind is CommandKind.PARAMETER
        try:
            kind = class_of(_SET if sets else command.type, command.target)
        except TypeMissing as error:
            # Slower ways without the package only where the package is not there: an installed
            # type is read by ROS itself.
            if command.kind is CommandKind.SERVICE and self._packageless.knows_type(command.type):
                self._without_package.add(address)
                return
            if command.kind is CommandKind.ACTION and self._make_bare_action(address, command):
                return
            if command.kind is CommandKind.TOPIC:
                bare = PackagelessPublisher(command, self._node, self._thread, self._types)
                self._bare_publishers[address] = bare
                return
            self._problems[address] = str(error)
            self._missing(error)
            return
        if command.kind is CommandKind.TOPIC:
            publisher = self._node.create_publisher(kind, command.target, 10)
            self._publishers[address] = (publisher, kind)
        elif command.kind is CommandKind.ACTION:
            form = installed_form(command, kind, self._node, self._thread)
            action = Ros2Action(command, form, self._node, self._thread)
            self._actions[address] = action
            action.hear_feedback(kind.Impl.FeedbackMessage)
        else:
            target = f"{command.target}/set_parameters" if sets else command.target
            # Made before it is needed: discovery takes a moment, in which the first call would
            # find nobody.
            client = _Client(self._node.create_client(kind, target), kind, {})
            self._clients[address] = client
            read = as_set if sets else outcome_of
            self._thread.add_client(
                client.entity.handle, kind.Response, _response_reader(client, read)
            )

    def _make_bare_action(self, address: str, command: Command) -> bool:
        """Make an action whose type is not installed; tell whether it is known at all."""
        found = packageless_action(command, self._node, self._thread, self._packageless)
        if found is None:
            return False
        form, feedback, feedback_hash = found
        action = Ros2Action(command, form, self._node, self._thread)
        self._actions[address] = action

        def hear() -> None:
            # Not known for a second: types that are not installed are tried first.
            kind = self._types.class_for(feedback, command.target, feedback_hash)
            if kind is not None:
                action.hear_feedback(kind)
                forget_error()

        self._types.when_tried(hear)
        return True

    def rejoin(self, device: str) -> None:
        """Make a device's clients and publishers anew; calls under way end as *unknown*."""
        for command_id, command in self._scope.devices[device].commands.items():
            address = f"{device}/{command_id}"
            self._close(address)
            self._make(address, command)

    def redescribe(self, scope: ConnectionScope) -> None:
        """Make what is new or other than it was; the rest stays, with its calls under way."""
        self._scope = scope
        wanted = {
            f"{device_id}/{command_id}": command
            for device_id, device in scope.devices.items()
            for command_id, command in device.commands.items()
        }
        for address, command in list(self._commands.items()):
            # Compared whole: the least change (a field, a type) may mean another message.
            if wanted.get(address) != command:
                self._close(address)
                del self._commands[address]
        for address, command in wanted.items():
            if address not in self._commands:
                self._make(address, command)

    def _close(self, address: str) -> None:
        self._problems.pop(address, None)
        self._without_package.discard(address)
        bare = self._bare_publishers.pop(address, None)
        if bare is not None:
            bare.close()
        publisher, _ = self._publishers.pop(address, (None, None))
        if publisher is not None:
            self._node.destroy_publisher(publisher)
        action = self._actions.pop(address, None)
        if action is not None:
            action.close(CommandOutcome(CommandPhase.UNKNOWN, _CUT))
        transition = self._transitions.pop(address, None)
        if transition is not None:
            transition.close(CommandOutcome(CommandPhase.UNKNOWN, _CUT))
        client = self._clients.pop(address, None)
        if client is not None:
            self._thread.remove_client(client.entity.handle)
            self._node.destroy_client(client.entity)
            # Nothing is known of what the robot did with them; "failed" might be a lie.
            for done in client.pending.values():
                done(CommandOutcome(CommandPhase.UNKNOWN, _CUT))

    def cut(self, device: str) -> None:
        """End a device's calls that are under way as *unknown*: nobody will answer them."""
        for command_id in self._scope.devices[device].commands:
            address = f"{device}/{command_id}"
            if (action := self._actions.get(address)) is not None:
                action.cut(CommandOutcome(CommandPhase.UNKNOWN, _GONE))
            if (transition := self._transitions.get(address)) is not None:
                transition.cut(CommandOutcome(CommandPhase.UNKNOWN, _GONE))
            if (client := self._clients.get(address)) is not None:
                # Emptied before anybody is told: who is told may begin the next call.
                waiting = list(client.pending.values())
                client.pending.clear()
                for done in waiting:
                    done(CommandOutcome(CommandPhase.UNKNOWN, _GONE))

    def offered(self, device: str) -> bool:
        """Tell whether anybody offers one of a device's services or actions now."""
        names = [f"{device}/{command}" for command in self._scope.devices[device].commands]
        # For these there is no client here that could be asked; the graph knows their services all
        # the same.
        own = self._without_package.intersection(names)
        if own:
            services = {name for name, _ in self._node.get_service_names_and_types()}
            if any(self._commands[name].target in services for name in own):
                return True
        return any(
            (name in self._clients and self._clients[name].entity.service_is_ready())
            or (name in self._actions and self._actions[name].ready)
            or (name in self._transitions and self._transitions[name].ready)
            for name in names
        )

    def absent(self, device: str) -> list[str]:
        """Name those of a device's services that nobody offers, and types not known here."""
        absent = []
        for command_id, command in self._scope.devices[device].commands.items():
            address = f"{device}/{command_id}"
            client = self._clients.get(address)
            if address in self._problems:
                absent.append(f"{command.target} (its type is not known here)")
            elif client is not None and not client.entity.service_is_ready():
                absent.append(f"{command.target} (no such service now)")
            elif address in self._actions and not self._actions[address].ready:
                absent.append(f"{command.target} (no such action now)")
            elif address in self._transitions and not self._transitions[address].ready:
                absent.append(f"{command.target} (no such life-cycle node now)")
        return absent

    @staticmethod
    def away() -> CommandOutcome:
        """Say that there is nobody to ask."""
        return CommandOutcome(CommandPhase.REFUSED, "the robot is not connected")

    def begin(
        self,
        address: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
        on_thread: Callable[[Callable[[], None]], None],
    ) -> Callable[[], None] | None:
        """Begin from any thread; see `CommandTarget.act`. Jobs go to ``on_thread``."""
        action = self._actions.get(address)
        goal = None if action is None else ActionGoal(done, action.progress_end)
        on_thread(lambda: self._act(address, fields, done, goal))
        if action is None or goal is None:
            return None
        # On the same thread as the beginning, so it cannot overtake it.
        return lambda: on_thread(lambda: action.cancel(goal))

    def _act(
        self,
        address: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
        goal: ActionGoal | None,
    ) -> None:
        problem = self._problems.get(address)
        if address not in self._commands:
            problem = "the command is not described any more"
        if problem is not None:
            done(CommandOutcome(CommandPhase.REFUSED, problem))
            return
        try:
            if address in self._without_package:
                self._packageless.call_service(self._commands[address], fields, done)
            elif address in self._bare_publishers:
                self._bare_publishers[address].publish_fields(fields, done)
            elif address in self._publishers:
                done(self._publish(address, fields))
            elif address in self._transitions:
                self._transitions[address].act(fields, done)
            elif goal is not None:
                self._actions[address].act(goal, fields)
            else:
                self._call(address, fields, done)
        except FieldError as error:
            done(CommandOutcome(CommandPhase.REFUSED, str(error)))

    def _publish(self, address: str, fields: dict[str, Scalar]) -> CommandOutcome:
        publisher, kind = self._publishers[address]
        message = kind()
        fill(message, fields)
        # Said now: a publication that nobody hears would count as done, and nothing would move.
        if publisher.get_subscription_count() == 0:
            target = self._commands[address].target
            return CommandOutcome(CommandPhase.REFUSED, f"nobody on the robot listens to {target}")
        publisher.publish(message)
        return CommandOutcome(CommandPhase.SUCCEEDED, "published")

    def _call(
        self, address: str, fields: dict[str, Scalar], done: Callable[[CommandOutcome], None]
    ) -> None:
        client = self._clients[address]
        request = client.kind.Request()
        command = self._commands[address]
        if command.kind is CommandKind.PARAMETER:
            request.parameters = parameters_of(command, fields)
        else:
            fill(request, fields)
        if not client.entity.service_is_ready():
            target = self._commands[address].target
            done(CommandOutcome(CommandPhase.REFUSED, f"the robot does not offer {target} now"))
            return
        # The oldest: dicts keep the order of what was put in.
        if len(client.pending) >= MAX_PENDING:
            client.pending.pop(next(iter(client.pending)))
        client.pending[client.entity.handle.send_request(request)] = done


def _response_reader(
    client: _Client, read: Callable[[Any], CommandOutcome]
) -> Callable[[int, Any], None]:
    def on_response(number: int, response: object) -> None:
        # None: cut or forgotten meanwhile, and its end was told then.
        done = client.pending.pop(number, None)
        if done is not None:
            done(read(response))

    return on_response
