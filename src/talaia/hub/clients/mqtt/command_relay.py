"""Commands and STOP from a broker to the hub, and what became of them back."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.mqtt.asked_commands import RefusedMessage, judge_command, judge_stop
from talaia.wire.browser import CommandUpdate, StopUpdate
from talaia.wire.frames import CommandPhase
from talaia.wire.mqtt.payloads import encode_answer

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.mqtt.asked_commands import InboundMessage
    from talaia.hub.clients.mqtt.publication import SitePublication
    from talaia.wire.browser import ToBrowser
    from talaia.wire.mqtt.topic_tree import CommandTopic

    # What was asked, the answer as JSON, and what its sender knows it by.
    SendsAnswer = Callable[[CommandTopic, bytes, bytes], None]
    ReportsRefused = Callable[[InboundMessage, RefusedMessage], None]

__all__ = ["CommandRelay"]

# Commands whose end is not known yet.
_MOST_WAITING = 100
_GOING_ON = frozenset({CommandPhase.ACCEPTED, CommandPhase.RUNNING})


class _Waiting(NamedTuple):
    asked: CommandTopic
    correlation: bytes


class CommandRelay:
    """Of one site and one account."""

    def __init__(
        self,
        connection: ClientConnection,
        clock: Clock,
        *,
        answer: SendsAnswer,
        report_refused: ReportsRefused,
    ) -> None:
        """Ask by ``connection``; tell who asked by ``answer``, and refusals to the log, too."""
        self._connection = connection
        self._clock = clock
        self._answer = answer
        self._report_refused = report_refused
        # By the command's or STOP's id.
        self._waiting: dict[str, _Waiting] = {}

    def receive_message(self, message: InboundMessage, publication: SitePublication) -> None:
        """Do what a message asks, or say why not."""
        if not message.asked.command:
            self._press_stop(message, publication)
            return
        now_us = self._clock.wall_ns() // 1000
        judged = judge_command(message, self._connection.description, publication, now_us)
        if isinstance(judged, RefusedMessage):
            self.refuse_message(message, judged)
            return
        if judged.id in self._waiting or len(self._waiting) >= _MOST_WAITING:
            self.refuse_message(message, RefusedMessage("this command is under way already"))
            return
        # Before it is asked: its end may come at once.
        self._waiting[judged.id] = _Waiting(message.asked, message.correlation)
        problem = self._connection.request(judged)
        if problem is not None:
            del self._waiting[judged.id]
            self.refuse_message(message, RefusedMessage(problem.message))

    def _press_stop(self, message: InboundMessage, publication: SitePublication) -> None:
        refused = judge_stop(message, publication)
        if refused is not None:
            self.refuse_message(message, refused)
            return
        press, why = self._connection.press_stop(message.asked.device)
        if why:
            self.refuse_message(message, RefusedMessage(why))
            return
        if len(self._waiting) < _MOST_WAITING:
            self._waiting[press] = _Waiting(message.asked, message.correlation)

    def refuse_message(self, message: InboundMessage, refused: RefusedMessage) -> None:
        """Tell why nothing is done."""
        self._report_refused(message, refused)
        if not refused.quiet:
            payload = encode_answer("", CommandPhase.REFUSED.value, refused.why)
            self._answer(message.asked, payload, message.correlation)

    def deliver_message(self, message: ToBrowser) -> None:
        """Tell who asked what became of it; all else is read where it stands."""
        match message:
            case CommandUpdate() if message.id in self._waiting:
                going_on = message.phase in _GOING_ON
                waiting = self._waiting[message.id] if going_on else self._waiting.pop(message.id)
                said = (message.id, message.phase.value, message.message)
                payload = encode_answer(*said, message.progress)
                self._answer(waiting.asked, payload, waiting.correlation)
            case StopUpdate() if message.id in self._waiting and message.latched:
                waiting = self._waiting.pop(message.id)
                phase = CommandPhase.SUCCEEDED.value
                payload = encode_answer(message.id, phase, "STOP is on")
                self._answer(waiting.asked, payload, waiting.correlation)
            case _:
                pass
