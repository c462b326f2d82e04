"""One description for another in a running gateway: every part is told, in the right order."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.gateway.errors import ChannelNumbersFull
from talaia.model.renames import changed_devices, list_renames
from talaia.model.topics import blurred_cameras

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.gateway.actuation import Actuation
    from talaia.gateway.reload.connection_exchange import ConnectionExchange
    from talaia.gateway.reload.current_description import CurrentDescription, PreparedDescription
    from talaia.gateway.samples.channel_numbering import ChannelNumbering
    from talaia.model.description_follower import DescriptionFollower
    from talaia.model.site import Site
    from talaia.wire.frames import DescriptionUpdate

__all__ = ["DescriptionReload"]

log = logging.getLogger(__name__)


class DescriptionReload:
    """Knows the description that counts, and puts another in its place. Event loop only."""

    def __init__(
        self,
        *,
        current: CurrentDescription,
        numbering: ChannelNumbering,
        connections: ConnectionExchange,
        actuation: Actuation,
        samples: DescriptionFollower[PreparedDescription],
        followers: Sequence[DescriptionFollower[Site]],
        say: Callable[[DescriptionUpdate], None],
        begin_again: Callable[[Site], None],
    ) -> None:
        """Begin with the description that the parts were made of.

        Args:
            current: see above.
            numbering: the numbers of channels.
            connections: says whether this machine can use those of another description.
            actuation: says what is under way, and lets go of devices.
            samples: numbers, keeps and sends samples by another description; before the hub is
                told of it, so that none is named by the wrong one.
            followers: take the description then, in this order.
            say: tells the hub.
            begin_again: ends this gateway in favour of a new one, for what cannot be exchanged.

        """
        self._current = current  # What counts now.
        self._numbering = numbering  # Grown before anything uses the new numbers.
        self._connections = connections
        self._actuation = actuation
        self._samples = samples
        self._followers = followers
        self._say = say
        self._begin_again = begin_again

    @property
    def now(self) -> PreparedDescription:
        """What counts."""
        return self._current.now

    @property
    def turn(self) -> int:
        """How often it was replaced."""
        return self._current.turn

    def report_since(self, turn: int) -> None:
        """Tell a hub that was greeted with an earlier description which one counts now."""
        if turn != self.turn:
            self._say(self.now.make_update(self._current.renamed))

    def reload_hindrance(self, after: Site) -> str:
        """Name what is under way that a change must not disturb; empty when nothing is."""
        # Any sequence: each may command any device.
        for sequence in self._actuation.sequences.running:
            return f"{sequence} is under way"
        command = self._actuation.commands.busy_with(changed_devices(self.now.site, after))
        return f"the command {command} is under way" if command else ""

    def leave_touched(self, after: Site | None) -> None:
        """End the driving of what a change touches; nobody drives it until the reload.

        With none, the change does not take place.
        """
        devices = frozenset() if after is None else changed_devices(self.now.site, after)
        self._actuation.driving.leave_devices(devices)
        # Looked at now: what is due has changed with the devices that are let go.
        self._actuation.timer.reset_timer()

    def has_left(self, after: Site) -> bool:
        """Tell whether all that was moving has been told to stand, for as long as it is to be."""
        return self._actuation.driving.is_silent(changed_devices(self.now.site, after))

    def apply_description(self, next_: PreparedDescription, change_id: str, who: str) -> None:
        """Exchange the description for another, at one blow; see `leave_touched`.

        Raises:
            SettingsError: a connection of it cannot be used here; all is as it was.

        """
        before, after = self.now.site, next_.site
        renamed = list_renames(before, after)
        # What records is made once: another plan needs another gateway.
        if (
            after.recording != before.recording
            or _night_differs(before, after)
            or _blurs_what_is_held(before, after)
        ):
            self._begin_again(after)
            return
        # What may fail comes first.
        self._connections.check_usable(after)
        try:
            self._numbering.add_channels(after, renamed)
        except ChannelNumbersFull as error:
            log.warning("%s; beginning again", error)
            self._begin_again(after)
            return
        # From here on nothing may fail: what is half exchanged cannot be taken back.
        self._current.replace_description(next_, renamed)
        self._samples.redescribe(next_)
        # After the samples: the hub takes the new list before the first batch that is named by it.
        self._say(next_.make_update(renamed, change_id, who))
        for follower in self._followers:
            follower.redescribe(after)
        self._actuation.timer.reset_timer()


def _blurs_what_is_held(before: Site, after: Site) -> bool:
    """Tell whether the last seconds that are held for a recording show what is blurred now."""
    return after.recording is not None and bool(
        blurred_cameras(after).keys() - blurred_cameras(before).keys()
    )


def _night_differs(before: Site, after: Site) -> bool:
    """Tell whether a night would be run otherwise: it begins anew then, from rest."""
    if before.night is None and after.night is None:
        return False
    return (before.night, before.place, before.enclosures) != (
        after.night,
        after.place,
        after.enclosures,
    )
