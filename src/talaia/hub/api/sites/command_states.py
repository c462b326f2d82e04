"""What signals and commands are of a robot's nodes, for pages that show what is possible. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from talaia.hub.api.schemas.observatory_schemas import StateNeed
from talaia.hub.auth.permissions import Grants, sees_signal
from talaia.model.connection import RosSource, source_as
from talaia.model.connections.ros import LIFECYCLE_TRANSITIONS, TRANSITION
from talaia.model.site import CommandKind, SignalType

if TYPE_CHECKING:
    from talaia.model.site import Command, Signal, Site

__all__ = ["command_part", "signal_part", "state_need"]

# A part of a node: neither, where a signal or command is of something else.
NodePart = Literal["", "parameter", "lifecycle"]

_COMMANDS: dict[CommandKind, NodePart] = {
    CommandKind.PARAMETER: "parameter",
    CommandKind.LIFECYCLE: "lifecycle",
}


def signal_part(signal: Signal) -> NodePart:
    """Tell whether a signal is a parameter or the state of a life cycle."""
    # Of another kind of connection both are empty.
    source = source_as(signal.source, RosSource)
    if source.parameter:
        return "parameter"
    return "lifecycle" if source.lifecycle else ""


def command_part(command: Command) -> NodePart:
    """Tell whether a command sets parameters or is a transition of a life cycle."""
    return _COMMANDS.get(command.kind, "")


def state_need(site: Site, device: str, command: Command, grants: Grants) -> StateNeed | None:
    """Give which state a transition of a life cycle needs; none where no page could tell it.

    The gateway asks the node itself: this is so that nobody has to try.
    """
    # An argument that the person chooses may be any of them.
    leads_from = LIFECYCLE_TRANSITIONS.get(str(command.fixed.get(TRANSITION)))
    if command.kind is not CommandKind.LIFECYCLE or leads_from is None:
        return None
    for signal_id, signal in site.devices[device].signals.items():
        # The first one that tells this node's state.
        said = source_as(signal.source, RosSource).lifecycle == command.target
        if (
            said
            and signal.type is SignalType.STATE
            and sees_signal(grants, site, device, signal_id)
        ):
            return StateNeed(
                channel=f"{device}/{signal_id}",
                max_age=signal.stale_after,
                states=list(signal.states),
                among=list(leads_from),
            )
    return None
