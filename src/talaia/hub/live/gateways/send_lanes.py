"""What waits to go down to a gateway: three lanes, STOP and driving first. Pure."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from talaia.wire.frames import (
    Ack,
    CommandCancel,
    CommandRequest,
    DriveFrame,
    LeaseForceRequest,
    LeaseRequest,
    OverrideRequest,
    ResetRequest,
    StopRequest,
    TwinFrame,
    TwinRequest,
)

if TYPE_CHECKING:
    from talaia.wire.frames import FromHub

__all__ = ["PrioritySendQueue"]

# In one lane; above it the gateway counts as gone.
_MOST_WAITING = 4096


class PrioritySendQueue:
    """Messages for one gateway, in order of priority."""

    def __init__(self) -> None:
        """Start empty."""
        # STOP; driving and leases; commands; all else. Never merged: a lane that is behind
        # holds up only those after it.
        self._lanes: tuple[deque[FromHub], ...] = (deque(), deque(), deque(), deque())

    def __bool__(self) -> bool:
        """Tell whether anything waits."""
        return any(self._lanes)

    def enqueue_message(self, message: FromHub) -> bool:
        """Take a message; a driving frame, or an ack, takes the place of an older one.

        That the driver has let go is not passed over for a press that follows: the gateway may
        be waiting for just that.

        Returns:
            False when so much waits that the gateway cannot be listening.

        """
        lane = self._lanes[_lane_of(message)]
        # Only the newest velocity counts, and an old one must not move the robot later.
        if isinstance(message, DriveFrame | TwinFrame):
            older = [
                waiting
                for waiting in lane
                # One that drives the twin takes no place of one that drives the robot.
                if isinstance(waiting, type(message))
                and (waiting.device, waiting.session) == (message.device, message.session)
                and (_lets_go(message) or not _lets_go(waiting))
            ]
            for frame in older:
                lane.remove(frame)
        # One says all that those before it said.
        elif isinstance(message, Ack):
            for ack in [waiting for waiting in lane if isinstance(waiting, Ack)]:
                if ack.boot == message.boot:
                    lane.remove(ack)
        lane.append(message)
        return len(lane) <= _MOST_WAITING

    def next_message(self) -> FromHub:
        """Take the most urgent message.

        Raises:
            IndexError: nothing waits.

        """
        for lane in self._lanes:
            if lane:
                return lane.popleft()
        raise IndexError("nothing waits")


def _lets_go(frame: DriveFrame | TwinFrame) -> bool:
    if isinstance(frame, DriveFrame):
        return not frame.asks
    return frame.linear == 0.0 and frame.angular == 0.0


def _lane_of(message: FromHub) -> int:
    match message:
        # Nothing stands before it, driving of the same device included.
        case StopRequest():
            return 0
        case DriveFrame() | LeaseRequest() | LeaseForceRequest() | ResetRequest():
            return 1
        case TwinFrame() | TwinRequest():
            return 1
        # Asked by people, who may wait for a driving frame, but not for acknowledgements.
        case CommandRequest() | CommandCancel() | OverrideRequest():
            return 2
        case _:
            return 3
