"""Who is acting on a device, so that nobody else acts against them unasked. Pure.

A holder is a person whose command is under way, or a safety sequence of the gateway's own. Whoever
else has a hold that lasts longer than a command (a night's executor) takes one with `add_holder`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

__all__ = ["DeviceHolder", "DeviceHolders"]


class DeviceHolder(NamedTuple):
    """One who acts on a device.

    Attributes:
        id: of what is under way: the command's.
        device: on which it acts.
        doing: what, in words for people.
        who: asked for it.
        since_ns: monotonic.
        safety: of the gateway itself, to make things safe: nobody may go over it.
        drives: by the lease of a device that is driven: who wants it asks for the lease.

    """

    id: str
    device: str
    doing: str
    who: str
    since_ns: int
    safety: bool = False
    drives: bool = False

    @property
    def firm(self) -> bool:
        """Whether nobody may act over it."""
        return self.safety or self.drives

    @property
    def words(self) -> str:
        """Who acts on what, for people."""
        if self.drives:
            return f"{self.who} drives it"
        who = "the gateway itself" if self.safety else self.who
        return f"{who} is acting on {self.doing}"

    def words_since(self, now_ns: int) -> str:
        """Say it with for how long; of who drives that is the lease's to say."""
        return self.words if self.drives else f"{self.words} (since {self.acting_s(now_ns):.0f} s)"

    def acting_s(self, now_ns: int) -> float:
        """For how long they have been acting (s)."""
        return (now_ns - self.since_ns) / SECOND


class DeviceHolders:
    """All who act now."""

    def __init__(self) -> None:
        """Begin with nobody."""
        # By the id of what is under way.
        self._holders: dict[str, DeviceHolder] = {}
        # Those that somebody was let act over, until the new one holds the device.
        self._interruptible: set[str] = set()
        # Told of each command that somebody asked for and that was accepted: device, who.
        self._listeners: list[Callable[[str, str], None]] = []
        # Names who drives a device of a kind that is held, by its lease; set by who knows leases.
        self.lease_holder: Callable[[str], str] = lambda _device: ""

    def subscribe_commands(self, listener: Callable[[str, str], None]) -> None:
        """Tell a part of the gateway of each command that was asked for and accepted."""
        self._listeners.append(listener)

    def announce_command(self, device: str, who: str) -> None:
        """Take in that a command of somebody begins, held for or not."""
        for listener in self._listeners:
            listener(device, who)

    def add_holder(self, holder: DeviceHolder) -> None:
        """Take in that somebody acts from now on."""
        self._holders[holder.id] = holder

    def release_holder(self, holder_id: str) -> None:
        """Take in that it has ended."""
        self._holders.pop(holder_id, None)
        self._interruptible.discard(holder_id)

    def let_interrupt(self, holder_id: str) -> None:
        """Let the next command take the device out of these hands.

        From here on it is in the new one's hands; how the old one ends the robot says.
        """
        self._interruptible.add(holder_id)

    def interrupt_holder(self, holder_id: str) -> DeviceHolder | None:
        """Take the device out of the hands of one who may be interrupted; give who it was."""
        if holder_id not in self._interruptible:
            return None
        holder = self._holders.get(holder_id)
        self.release_holder(holder_id)
        return holder

    def all_holders(self) -> list[DeviceHolder]:
        """Give all who act, in the order in which they began."""
        return list(self._holders.values())

    def other_holder(self, devices: Collection[str], who: str) -> str:
        """Name a person who acts on one of these devices now, other than ``who``; empty: nobody."""
        for holder in self._holders.values():
            if holder.device in devices and holder.who != who and not holder.safety:
                return holder.who
        return ""

    def find_holder(self, holder_id: str) -> DeviceHolder | None:
        """Give one who acts, by the id."""
        return self._holders.get(holder_id)

    def holder_against(self, device: str, who: str) -> DeviceHolder | None:
        """Give the one whom a command of ``who`` would act against; the gateway itself first.

        What the same person asks for replaces what they asked for before.
        """
        found = [
            holder
            for holder in self._holders.values()
            if holder.device == device and (holder.safety or holder.who != who)
        ]
        driver = self.lease_holder(device)
        if driver not in ("", who):
            found.append(DeviceHolder("", device, "", driver, 0, drives=True))
        # Who holds the lease comes before those who merely act: they would only be in between.
        return max(
            found, key=lambda holder: (holder.safety, holder.drives, holder.since_ns), default=None
        )

    def words_against(self, device: str, who: str) -> str:
        """Say who acts against what ``who`` would do; empty: nobody."""
        holder = self.holder_against(device, who)
        return "" if holder is None else holder.words
