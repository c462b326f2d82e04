"""What a robot was sent in somebody's name."""

from __future__ import annotations

from talaia.wire import frames
from talaia.wire.frames import LeaseOp


def sent_for(gateway, name: str) -> set[tuple[str, str]]:
    """Say what a gateway was sent in somebody's name that could move or change something."""
    sent = set()
    for message in gateway.heard:
        if getattr(message, "who", "") != name:
            continue
        match message:
            case frames.CommandRequest():
                sent.add(("call", message.device))
            case frames.StopRequest():
                sent.add(("stop", message.device))
            case frames.LeaseRequest(op=LeaseOp.FREE):
                pass
            case frames.LeaseRequest():
                sent.add(("lease", message.device))
            case _:
                sent.add((type(message).__name__, message.device))
    # A lease is not given here, and without one nothing is driven.
    assert not [message for message in gateway.heard if isinstance(message, frames.DriveFrame)]
    return sent
