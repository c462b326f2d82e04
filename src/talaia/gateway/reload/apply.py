"""One description for another in a running gateway: every part is told, in the right order."""

from __future__ import annotations

import hashlib
import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia import __version__
from talaia.gateway.adapters.connection_scope import ReconfigurableAdapter, shares_of
from talaia.gateway.change_policy import AcceptedChanges
from talaia.gateway.errors import ChannelNumbersFull
from talaia.gateway.spool.files import SegmentHead
from talaia.model.renames import renames, touched
from talaia.model.yaml_text.load import dump_site
from talaia.wire.frames import DescriptionUpdate, Hello
from talaia.wire.sealing import deflated

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
    from talaia.gateway.samples.batching import Batcher
    from talaia.gateway.samples.channel_numbering import ChannelNumbering
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.model.site import Site

__all__ = ["DescriptionReload", "PreparedDescription", "ReloadTargets", "catalogue_of", "prepared"]

log = logging.getLogger(__name__)


def catalogue_of(site: Site) -> str:
    """Name the channel list: the same list has the same name, in every run."""
    listed = "\n".join(f"{each.address} {each.text:d}" for each in site.channels())
    return hashlib.sha256(listed.encode()).hexdigest()[:16]


class PreparedDescription(NamedTuple):
    """A description with what takes long to make of it.

    Attributes:
        site: all of it, found devices too.
        source: its text as a person wrote it; empty where it is not from one file.
        said: as YAML.
        catalogue: the name of its channel list.
        addresses: of the channels, in order.

    """

    site: Site
    source: str
    said: str
    catalogue: str
    addresses: list[str]

    def hello(self, boot: str, time_us: int, accepts: AcceptedChanges) -> Hello:
        """Give what a hub is greeted with."""
        return Hello(
            version=__version__,
            site=self.site.site,
            boot=boot,
            description=self.said,
            catalogue=self.catalogue,
            time_us=time_us,
            source=deflated(self.source) if self.source else b"",
            accepts=accepts if self.source else AcceptedChanges.NO,
        )

    def described(
        self, renamed: dict[str, str], change_id: str = "", who: str = ""
    ) -> DescriptionUpdate:
        """Give what the hub is told."""
        return DescriptionUpdate(
            description=deflated(self.said),
            catalogue=self.catalogue,
            addresses=self.addresses,
            renamed=renamed,
            source=deflated(self.source) if self.source else b"",
            id=change_id,
            who=who,
        )


def prepared(site: Site, source: str) -> PreparedDescription:
    """Make ready what takes long; any thread."""
    addresses = [each.address for each in site.channels()]
    return PreparedDescription(site, source, dump_site(site), catalogue_of(site), addresses)


class ReloadTargets(NamedTuple):
    """All that a description is told to.

    Attributes:
        make: makes the adapter of a connection.
        followers: take the description when all others have.

    """

    boot: str
    clock: Clock
    roster: ChannelNumbering
    batcher: Batcher
    keeper: SpoolThread
    reach: DeviceReachability
    many: MultiAdapter
    adapters: dict[str, tuple[Adapter, ConnectionStatus]]
    make: Callable[[ConnectionScope], tuple[Adapter, ConnectionStatus]]
    acting: Actuation
    newest: NewestValues | None
    tapes: TriggeredRecorder | None
    followers: tuple[Callable[[Site], None], ...]


class DescriptionReload:
    """Knows the description that counts, and puts another in its place. Event loop only.

    Attributes:
        now: what counts.
        shares: what each connection serves of it.
        turn: how often it was exchanged.

    """

    def __init__(
        self,
        begun: PreparedDescription,
        parts: ReloadTargets,
        say: Callable[[DescriptionUpdate], None],
        begin_again: Callable[[Site], None],
    ) -> None:
        """Begin with the description that the parts were made of.

        Args:
            begun: see above.
            parts: see `ReloadTargets`.
            say: tells the hub.
            begin_again: ends this gateway in favour of a new one, for what cannot be exchanged.

        """
        self.now = begun
        self.turn = 0
        self.shares = {each.name: each for each in shares_of(begun.site, parts.roster)}
        self._parts = parts
        self._say = say
        self._begin_again = begin_again
        self._renamed: dict[str, str] = {}

    def said_since(self, turn: int) -> None:
        """Tell a hub that was greeted with an earlier description which one counts now."""
        if turn != self.turn:
            self._say(self.now.described(self._renamed))

    def hindrance(self, after: Site) -> str:
        """Name what is under way that a change must not disturb; empty when nothing is."""
        for sequence in self._parts.acting.sequences.running:
            return f"{sequence} is under way"
        command = self._parts.acting.commanding.busy_with(touched(self.now.site, after))
        return f"the command {command} is under way" if command else ""

    def leave(self, after: Site | None) -> None:
        """End the driving of what a change touches; nobody drives it until the exchange.

        With none, the change does not take place.
        """
        devices = frozenset() if after is None else touched(self.now.site, after)
        self._parts.acting.control.leave(devices)
        self._parts.acting.pacer.touch()

    def left(self, after: Site) -> bool:
        """Tell whether all that was moving has been told to stand, for as long as it is to be."""
        return self._parts.acting.control.silent(touched(self.now.site, after))

    def put(self, next_: PreparedDescription, change_id: str, who: str) -> None:
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
            parts.roster.take(after, renamed)
        except ChannelNumbersFull as error:
            log.warning("%s; beginning again", error)
            self._begin_again(after)
            return
        devices = touched(before, after)
        now_ns = parts.clock.monotonic_ns()
        self.now, self.turn = next_, self.turn + 1
        earlier = {old: renamed.get(new, new) for old, new in self._renamed.items()}
        self._renamed = {**earlier, **renamed}
        self._data(next_)
        self._say(next_.described(renamed, change_id, who))
        of = {name: after.connection_of(name) for name in after.devices}
        parts.reach.redescribe(of)
        if parts.tapes is not None:
            parts.tapes.redescribe(after)
        self._adapters(after, of)
        parts.acting.redescribe(after, devices, now_ns)
        for follow in parts.followers:
            follow(after)
        parts.acting.pacer.touch()

    def _data(self, next_: PreparedDescription) -> None:
        """From here on samples are numbered, kept and sent by the new list of channels."""
        parts = self._parts
        parts.batcher.redescribe(next_.catalogue, parts.roster.order(next_.site))
        parts.keeper.redescribe(SegmentHead(parts.boot, next_.catalogue, next_.addresses))
        if parts.newest is not None:
            parts.newest.redescribe(parts.roster.numbers(next_.site))

    def _try(self, after: Site) -> None:
        """See that this machine can speak to connections of a new kind or place."""
        for share in shares_of(after):
            known = self.shares.get(share.name)
            if known is None or known.connection != share.connection:
                self._parts.make(share)

    def _adapters(self, after: Site, of: dict[str, str]) -> None:
        parts = self._parts
        adapters: dict[str, tuple[Adapter, ConnectionStatus]] = {}
        shares = {each.name: each for each in shares_of(after, parts.roster)}
        for name, share in shares.items():
            known = self.shares.get(name)
            pair = parts.adapters.get(name)
            if pair is None or known is None or known.connection != share.connection:
                adapters[name] = parts.make(share)
            elif known == share:
                adapters[name] = pair
            elif isinstance(pair[0], ReconfigurableAdapter):
                pair[0].redescribe(share)
                adapters[name] = pair
            else:
                adapters[name] = parts.make(share)
        parts.adapters.clear()
        parts.adapters.update(adapters)
        self.shares = shares
        parts.many.redescribe(of, adapters)
