"""Commands as calls of services whose types are not installed, through a process of their own.

Requests and answers are written and read here, by the definitions in files; `service_caller` only
carries bytes. If that process hangs it is ended with SIGKILL, and what it had sent is *unknown*.
Long, because who orders, reads and ends a call share one process and one lock.
"""

from __future__ import annotations

import base64
import contextlib
import json
import logging
import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros2.made_types.made_message_class import problem_here
from talaia.gateway.adapters.ros2.made_types.self_test import self_test_problem
from talaia.gateway.adapters.ros2.requests import fill, outcome_of
from talaia.gateway.adapters.ros2.system_ros.process import BRIDGE_SCRIPT
from talaia.gateway.adapters.ros2.system_ros.shared_process import SHARED
from talaia.gateway.adapters.ros2.type_definitions.definition_finder import DefinitionFinder
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import decoder_of
from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder
from talaia.gateway.errors import FieldError, TypeMissing
from talaia.gateway.ports import CommandOutcome
from talaia.ros_installation import bridge_environment
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.gateway.adapters.ros2.type_definitions.action_definition import ActionDefinition
    from talaia.model.site import Command
    from talaia.wire.frames import Scalar

__all__ = ["CarriedRequest", "PackagelessServices"]

log = logging.getLogger(__name__)
# Beyond a command's own time, for the process to begin and to find the service.
_SLACK_S = 15.0
# What it may take to end by itself.
_FAREWELL_S = 2.0
_GONE = "the process that called it has ended; look at the device to see what it did"


class _ServiceCodec(NamedTuple):
    """How a service's request is written and its answer read, and the hash of its type."""

    type_hash: str
    request: MessageEncoder
    read: Callable[[bytes], object]


class CarriedRequest(NamedTuple):
    """A request that is written already.

    Attributes:
        timeout_s: its answer takes no longer; none where it may take for ever.

    """

    service: str
    type_name: str
    type_hash: str
    raw: bytes
    timeout_s: float | None


class _OpenCall:
    """A call under way."""

    def __init__(
        self,
        done: Callable[[CommandOutcome], None],
        read: Callable[[bytes], object],
        deliver: Callable[[object], None] | None = None,
    ) -> None:
        self.done, self.read = done, read
        # Gets the answer itself; none where that ends a command.
        self.deliver = deliver
        self.sent = False
        self.timer: threading.Timer | None = None


class PackagelessServices:
    """The calls of one connection. Any thread; never blocks."""

    def __init__(self, *, node: str, domain: int, named: Path | None) -> None:
        """Begin nothing yet.

        Args:
            node: name of the gateway's node; the calls' is made of it.
            domain: the ROS domain.
            named: a folder with definitions; none where the description names none.

        """
        self._node, self._domain, self._named = f"{node}_calls", domain, named
        # Writes to the child and waits for its start, which must not hold up the wait set.
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="talaia-ros2-calls")
        self._finder: DefinitionFinder | None = None
        # By type: a definition is read once, and asked for anew when the gateway begins.
        self._codecs: dict[str, _ServiceCodec] = {}
        # What follows is guarded by the lock: the worker, the reader and timers use it.
        self._lock = threading.Lock()
        # None before the first call, and after it has ended.
        self._child: subprocess.Popen[bytes] | None = None
        # By the number that the child knows them by.
        self._open: dict[int, _OpenCall] = {}
        self._numbers = count(1)

    def close(self) -> None:
        """End the process; calls under way end as *unknown*."""
        self._worker.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            child = self._child
        if child is None:
            return
        # Its input ends, and so does it: one that is killed leaves shared memory behind.
        with contextlib.suppress(OSError):
            assert child.stdin is not None  # noqa: S101 - it is a pipe
            child.stdin.close()
        try:
            child.wait(_FAREWELL_S)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()

    def knows_type(self, type_name: str) -> bool:
        """Tell whether a service's type is defined in files; reads them."""
        try:
            self._codec_of(type_name, "")
        except (TypeMissing, BadDefinition):
            return False
        return True

    def call_service(
        self, command: Command, fields: dict[str, Scalar], done: Callable[[CommandOutcome], None]
    ) -> None:
        """Call a command's service; see `CommandTarget.act` for ``done``."""
        self._worker.submit(self._prepare_call, command, dict(fields), done)

    def carry_request(
        self,
        request: CarriedRequest,
        read: Callable[[bytes], object],
        deliver: Callable[[object], None],
        failed: Callable[[CommandOutcome], None],
    ) -> None:
        """Call a service; from another thread either the answer is told, or why there is none."""
        self._worker.submit(self._carry, request, _OpenCall(failed, read, deliver))

    # ── on the worker ──

    def _carry(self, request: CarriedRequest, call: _OpenCall) -> None:
        if problem := problem_here() or self_test_problem():
            missing = TypeMissing(request.type_name, request.service, problem)
            call.done(CommandOutcome(CommandPhase.REFUSED, str(missing)))
            return
        order = {
            "service": request.service,
            "type": request.type_name,
            "hash": request.type_hash,
            "request": base64.b64encode(request.raw).decode(),
        }
        self._send_order(order, call, request.timeout_s)

    def find_action(self, type_name: str) -> tuple[ActionDefinition, dict[str, str]] | None:
        """Give an action's definition in files, and the hashes of its services by their names.

        None where there is none. Reads files.
        """
        finder = self._known_finder()
        try:
            found = finder.find_action(type_name, "")
        except (TypeMissing, BadDefinition):
            return None
        services = (found.send_goal, found.get_result)
        return found, {service.name: finder.hash_of_service(service) for service in services}

    def _prepare_call(
        self, command: Command, fields: dict[str, Scalar], done: Callable[[CommandOutcome], None]
    ) -> None:
        problem = problem_here() or self_test_problem()
        if problem:
            missing = TypeMissing(command.type, command.target, problem)
            done(CommandOutcome(CommandPhase.REFUSED, str(missing)))
            return
        try:
            codec = self._codec_of(command.type, command.target)
            message = codec.request.new_message()
            fill(message, fields)
            request = codec.request.encode_message(message)
        except (TypeMissing, BadDefinition, FieldError) as error:
            done(CommandOutcome(CommandPhase.REFUSED, str(error)))
            return
        order = {
            "service": command.target,
            "type": command.type,
            "hash": codec.type_hash,
            "request": base64.b64encode(request).decode(),
        }
        self._send_order(order, _OpenCall(done, codec.read), command.timeout)

    def _codec_of(self, type_name: str, used_by: str) -> _ServiceCodec:
        found = self._codecs.get(type_name)
        if found is None:
            service, type_hash = self._known_finder().find_service(type_name, used_by)
            found = _ServiceCodec(
                type_hash,
                MessageEncoder(service.request),
                decoder_of(service.response, proven=True),
            )
            self._codecs[type_name] = found
        return found

    def _known_finder(self) -> DefinitionFinder:
        if self._finder is None:
            self._finder = DefinitionFinder(self._named)
        return self._finder

    def _send_order(self, order: dict[str, Any], call: _OpenCall, timeout_s: float | None) -> None:
        with self._lock:
            child = self._child or self._begin_child()
            number = next(self._numbers)
            self._open[number] = call
            if timeout_s is not None:
                call.timer = threading.Timer(timeout_s + _SLACK_S, self._end_hung, [child, number])
                call.timer.daemon = True
                call.timer.start()
        assert child.stdin is not None  # noqa: S101 - it is a pipe
        try:
            child.stdin.write(json.dumps({"number": number, **order}).encode() + b"\n")
            child.stdin.flush()
        except OSError:
            # Its reader tells what has become of it.
            log.warning("the process that calls services does not listen")

    def _begin_child(self) -> subprocess.Popen[bytes]:
        command, kept = [sys.executable, "-m", f"{__package__}.service_caller"], dict(os.environ)
        if SHARED.in_use:
            # As the bridge is started; not by it, for a call that hangs must not hold up driving.
            command = [*SHARED.python_command(), str(BRIDGE_SCRIPT), "service-caller"]
            kept = bridge_environment(os.environ)
        child = subprocess.Popen(  # noqa: S603 - our own module, by a Python that has rclpy
            [*command, self._node],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**kept, "ROS_DOMAIN_ID": str(self._domain)},
        )
        self._child = child
        reader = threading.Thread(
            target=self._read_answers, args=[child], name="talaia-ros2-answers", daemon=True
        )
        reader.start()
        return child

    # ── on other threads ──

    def _read_answers(self, child: subprocess.Popen[bytes]) -> None:
        assert child.stdout is not None  # noqa: S101 - it is a pipe
        for line in child.stdout:
            self._on_line(json.loads(line))
        child.wait()
        with self._lock:
            # The next call begins another.
            if self._child is child:
                self._child = None
            gone, self._open = list(self._open.values()), {}
        for call in gone:
            self._end_call(call, CommandOutcome(_phase_without_answer(call), _GONE))
        for stream in (child.stdin, child.stdout):
            with contextlib.suppress(OSError):
                if stream is not None:
                    stream.close()

    def _on_line(self, told: dict[str, Any]) -> None:
        with self._lock:
            call = self._open.get(told["number"])
            if call is None:
                return
            if told.get("sent"):
                # What is said of it from here on cannot be *refused*.
                call.sent = True
                return
            del self._open[told["number"]]
        if "refused" in told:
            self._end_call(call, CommandOutcome(CommandPhase.REFUSED, told["refused"]))
            return
        try:
            message = call.read(base64.b64decode(told["answer"]))
            if call.deliver is not None:
                self._deliver(call, message)
                return
            outcome = outcome_of(message)
        except FieldError as error:
            outcome = CommandOutcome(CommandPhase.UNKNOWN, f"its answer cannot be read: {error}")
        self._end_call(call, outcome)

    def _end_hung(self, child: subprocess.Popen[bytes], number: int) -> None:
        # A child that hangs holds both the interpreter and its writer: SIGTERM would not be heard.
        with self._lock:
            late = number in self._open
        if late:
            log.warning("the process that calls services does not answer; it is ended")
            child.kill()

    @staticmethod
    def _deliver(call: _OpenCall, message: object) -> None:
        if call.timer is not None:
            call.timer.cancel()
        if call.deliver is not None:
            call.deliver(message)

    @staticmethod
    def _end_call(call: _OpenCall, outcome: CommandOutcome) -> None:
        if call.timer is not None:
            call.timer.cancel()
        call.done(outcome)


def _phase_without_answer(call: _OpenCall) -> CommandPhase:
    return CommandPhase.UNKNOWN if call.sent else CommandPhase.REFUSED
