"""PHD2's event protocol: lines in, what they mean out. Pure.

As published by the project (Open PHD Guiding, *Event Monitoring*): a TCP server on port 4400 sends
one JSON object a line, events with ``Event`` and answers with ``id``; a client sends JSON-RPC 2.0
requests, a line each.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["PORT", "Phd2Answer", "Phd2Reader", "Phd2Settle", "encode_request"]

PORT = 4400
# PHD2's lines are some hundred bytes; a calibration's are a few thousand.
_LONGEST_LINE = 256 * 1024
# States in which a star is held.
_HOLDS = frozenset({"Guiding"})


class Phd2Settle(NamedTuple):
    """When guiding counts as settled: within so many pixels for ``time`` s, in ``timeout`` s."""

    pixels: float = 1.5
    time: float = 8.0
    timeout: float = 60.0


class Phd2Answer(NamedTuple):
    """An answer to a request.

    Attributes:
        id: of the request.
        result: whatever was asked for.
        error: in PHD2's words; empty when it went well.

    """

    id: int
    result: object
    error: str


def encode_request(number: int, method: str, params: Sequence[object] = ()) -> bytes:
    """Write a request as a line."""
    request = {"jsonrpc": "2.0", "method": method, "params": list(params), "id": number}
    return json.dumps(request).encode() + b"\r\n"


class Phd2Reader:
    """What PHD2 has said so far.

    Attributes:
        state: its ``AppState``: Stopped, Selected, Calibrating, Guiding, LostLock, Paused, Looping.
        settled: how the last settling ended: none while it goes on, empty when well, else why not.
        problem: why the star is not held; empty while it is.
        error: of the last guide step (pixels); NaN before the first.

    """

    def __init__(self) -> None:
        """Know nothing yet."""
        self.state = ""
        self.settled: str | None = None
        self.problem = ""
        self.error = math.nan
        self._rest = b""

    def begin_settling(self) -> None:
        """Forget how the last settling ended: a new one was asked for."""
        self.settled = None

    def feed_bytes(self, data: bytes) -> list[Phd2Answer]:
        """Take what has come; give the answers in it. A line that is no JSON object is left out.

        Raises:
            ValueError: a line has no end: that is not PHD2.

        """
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > _LONGEST_LINE:
            raise ValueError("a line has no end: that is not PHD2")
        answers = []
        for line in lines:
            try:
                said = json.loads(line)
            except ValueError:
                continue
            if not isinstance(said, dict):
                continue
            if isinstance(said.get("Event"), str):
                self._hear_event(said)
            elif isinstance(said.get("id"), int):
                answers.append(_answer_of(said))
        return answers

    def _hear_event(self, said: dict[str, object]) -> None:
        match said["Event"]:
            case "AppState":
                self._set_state(str(said.get("State", "")))
            case "GuideStep":
                self._set_state("Guiding")
                off = said.get("dx"), said.get("dy")
                if all(isinstance(value, (int, float)) for value in off):
                    self.error = math.hypot(*(float(str(value)) for value in off))
            case "StartGuiding" | "Resumed":
                self._set_state("Guiding")
            case "StarLost":
                self.state = "LostLock"
                self.problem = f"the guide star is lost: {said.get('Status') or 'no reason given'}"
            case "GuidingStopped" | "LoopingExposuresStopped":
                self._set_state("Stopped")
            case "Paused":
                self._set_state("Paused")
            case "StartCalibration":
                self._set_state("Calibrating")
            case "CalibrationFailed":
                self.problem = f"the calibration failed: {said.get('Reason') or 'no reason given'}"
            case "SettleDone":
                good = said.get("Status") == 0
                self.settled = "" if good else str(said.get("Error") or "it did not settle")
            case _:
                pass

    def _set_state(self, state: str) -> None:
        self.state = state
        if state in _HOLDS:
            self.problem = ""
        elif state in ("Stopped", "LostLock", "Paused"):
            self.problem = self.problem or f"PHD2 does not guide: {state}"


def _answer_of(said: dict[str, object]) -> Phd2Answer:
    number, error = said.get("id"), said.get("error")
    words = ""
    if isinstance(error, dict):
        words = str(error.get("message") or f"error {error.get('code')}")
    elif error is not None:
        words = str(error)
    return Phd2Answer(number if isinstance(number, int) else 0, said.get("result"), words)
