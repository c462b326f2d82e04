"""One description for another in a running gateway: every part is told, in the right order."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.connection_scope import ReconfigurableAdapter, scopes_of
from talaia.gateway.errors import ChannelNumbersFull
from talaia.gateway.spool.files import SegmentHead
from talaia.model.renames import renames, touched

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.actuation import Actuation
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.connectivity import DeviceReachability
    from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
    from talaia.gateway.legacy.messages import NewestValues
    from talaia.gateway.ports import Adapter
    from talaia.gateway.recording.recorders import TriggeredRecorder
    from talaia.gateway.reload.current_description import CurrentDescription, PreparedDescription
    from talaia.gateway.samples.batching import Batcher
    from talaia.gateway.samples.channel_numbering import ChannelNumbering
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.model.site import Site
    from talaia.wire.frames import DescriptionUpdate

__all__ = ["DescriptionReload", "ReloadTargets"]

log = logging.getLogger(__name__)


class ReloadTargets(NamedTuple):
    """All that a description is told to.

    Attributes:
        make: makes the adapter of a connection.
        followers: take the description when all others have.

    """

    boot: str
    clock: Clock
    numbering: ChannelNumbering
    batcher: Batcher
    spool: SpoolThread
    reachability: DeviceReachability
    adapter: MultiAdapter
    adapters: dict[str, tuple[Adapter, ConnectionStatus]]
    make: Callable[[ConnectionScope], tuple[Adapter, ConnectionStatus]]
    actuation: Actuation
    newest: NewestValues | None
    recorders: TriggeredRecorder | None
    followers: tuple[Callable[[Site], None], ...]


class DescriptionReload:
    """Knows the description that counts, and puts another in its place. Event loop only.

    Attributes:
        scopes: what each connection serves of what counts.

    """

    def __init__(
        self,
        current: CurrentDescription,
        parts: ReloadTargets,
        say: Callable[[DescriptionUpdate], None],
        begin_again: Callable[[Site], None],
    ) -> None:
        """Begin with the description that the parts were made of.

        Args:
            current: see above.
            parts: see `ReloadTargets`.
            say: tells the hub.
            begin_again: ends this gateway in favour of a new one, for what cannot be exchanged.

        """
        self._current = current
        self.scopes = {scope.name: scope for scope in scopes_of(current.now.site, parts.numbering)}
        self._parts = parts
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
            self._say(self.now.described(self._current.renamed))

    def hindrance(self, after: Site) -> str:
        """Name what is under way that a change must not disturb; empty when nothing is."""
        for sequence in self._parts.actuation.sequences.running:
            return f"{sequence} is under way"
        command = self._parts.actuation.commands.busy_with(touched(self.now.site, after))
        return f"the command {command} is under way" if command else ""

    def leave(self, after: Site | None) -> None:
        """End the driving of what a change touches; nobody drives it until the reload.

        With none, the change does not take place.
        """
        devices = frozenset() if after is None else touched(self.now.site, after)
        self._parts.actuation.driving.leave(devices)
        self._parts.actuation.timer.touch()

    def left(self, after: Site) -> bool:
        """Tell whether all that was moving has been told to stand, for as long as it is to be."""
        return self._parts.actuation.driving.silent(touched(self.now.site, after))

    def apply_description(self, next_: PreparedDescription, change_id: str, who: str) -> None:
        """Exchange the description for another, at one blow; see `leave`.

        Raises:
            SettingsError: a connection of it cannot be used here; all is as it was.

        """
        before, after, parts = self.now.site, next_.site, self._parts
        renamed = renames(before, after)
        if after.recording != before.recording:
            self._begin_again(after)
            return
        # What may fail comes first.
        self._try(after)
        try:
            parts.numbering.add_channels(after, renamed)
        except ChannelNumbersFull as error:
            log.warning("%s; beginning again", error)
            self._begin_again(after)
            return
        devices = touched(before, after)
        now_ns = parts.clock.monotonic_ns()
        self._current.replace(next_, renamed)
        self._data(next_)
        self._say(next_.described(renamed, change_id, who))
        of = {name: after.connection_of(name) for name in after.devices}
        parts.reachability.redescribe(of)
        if parts.recorders is not None:
            parts.recorders.redescribe(after)
        self._adapters(after, of)
        parts.actuation.redescribe(after, devices, now_ns)
        for follow in parts.followers:
            follow(after)
        parts.actuation.timer.touch()

    def _data(self, next_: PreparedDescription) -> None:
        """From here on samples are numbered, kept and sent by the new list of channels."""
        parts = self._parts
        parts.batcher.redescribe(next_.catalogue, parts.numbering.order(next_.site))
        parts.spool.redescribe(SegmentHead(parts.boot, next_.catalogue, next_.addresses))
        if parts.newest is not None:
            parts.newest.redescribe(parts.numbering.numbers(next_.site))

    def _try(self, after: Site) -> None:
        """See that this machine can speak to connections of a new kind or place."""
        for scope in scopes_of(after):
            known = self.scopes.get(scope.name)
            if known is None or known.connection != scope.connection:
                self._parts.make(scope)

    def _adapters(self, after: Site, of: dict[str, str]) -> None:
        parts = self._parts
        adapters: dict[str, tuple[Adapter, ConnectionStatus]] = {}
        scopes = {scope.name: scope for scope in scopes_of(after, parts.numbering)}
        for name, scope in scopes.items():
            known = self.scopes.get(name)
            pair = parts.adapters.get(name)
            if pair is None or known is None or known.connection != scope.connection:
                adapters[name] = parts.make(scope)
            elif known == scope:
                adapters[name] = pair
            elif isinstance(pair[0], ReconfigurableAdapter):
                pair[0].redescribe(scope)
                adapters[name] = pair
            else:
                adapters[name] = parts.make(scope)
        parts.adapters.clear()
        parts.adapters.update(adapters)
        self.scopes = scopes
        parts.adapter.redescribe(of, adapters)
