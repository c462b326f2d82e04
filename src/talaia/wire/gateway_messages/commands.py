"""One-shot commands between gateway and hub."""

from __future__ import annotations

from talaia.wire.gateway_messages.field_types import Arguments, Name, Sentence, Units, Word
from talaia.wire.gateway_messages.relayed_fields import CommandFields, CommandPhase
from talaia.wire.message import Message

__all__ = ["CommandCancel", "CommandPhase", "CommandRequest", "CommandState"]


class CommandState(CommandFields, frozen=True, kw_only=True, tag="command_state"):
    """Where a one-shot command stands, in the robot's own words where it gave any.

    Attributes:
        blocked_by: refused because of this command (its id) of somebody else, which is under way:
            asked anew with it as ``over``, it is done all the same.
        acting: who acts on the device by it, and on what, in words; empty: nobody, or no longer.
        acting_s: for how long already (s).
        over: told once, as it begins: whose command it interrupts, in words, with its id.

    """

    over: Sentence = ""


class CommandRequest(Message, frozen=True, kw_only=True, tag="command_ask"):
    """Do this once. The id is the asker's; an id is acted on at most once.

    Attributes:
        units: the unit that the asker was shown for each argument; another than the description
            has now is refused.
        over: the id of somebody else's command that is under way and may be interrupted by this.

    """

    id: Name
    device: Name
    command: Name
    args: Arguments = {}
    units: Units = {}
    # Not accepted within so long, it is refused (ms).
    ttl_ms: float
    who: Name
    over: Word = ""


class CommandCancel(Message, frozen=True, kw_only=True, tag="command_cancel"):
    """End a command that is under way, if the robot can; its state tells what came of it."""

    id: Name
    device: Name
    who: Name
