"""The description that counts, with what takes long to make of it."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, NamedTuple

from talaia import __version__
from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.video.camera import can_film
from talaia.model.yaml_text.load import dump_site
from talaia.wire.frames import DescriptionUpdate, Hello
from talaia.wire.sealing import compress_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.site import Site

__all__ = ["CurrentDescription", "PreparedDescription", "catalogue_of", "prepare_description"]


def catalogue_of(site: Site) -> str:
    """Name the channel list: the same list has the same name, in every run."""
    # Order and kind count: a sample carries a place in this list and nothing else.
    listed = "\n".join(f"{channel.address} {channel.text:d}" for channel in site.channels())
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

    def make_hello(
        self,
        *,
        boot: str,
        time_us: int,
        accepts: AcceptedChanges,
        acked: int = -1,
        takes: Sequence[str] = (),
    ) -> Hello:
        """Give what a hub is greeted with."""
        return Hello(
            version=__version__,
            site=self.site.site,
            boot=boot,
            description=self.said,
            catalogue=self.catalogue,
            time_us=time_us,
            source=compress_text(self.source) if self.source else b"",
            # Without a text there is nothing that a change could begin with.
            accepts=accepts if self.source else AcceptedChanges.NO,
            acked=acked,
            takes=list(takes),
        )

    def make_update(
        self, renamed: dict[str, str], change_id: str = "", who: str = ""
    ) -> DescriptionUpdate:
        """Give what the hub is told."""
        return DescriptionUpdate(
            description=compress_text(self.said),
            catalogue=self.catalogue,
            addresses=self.addresses,
            renamed=renamed,
            source=compress_text(self.source) if self.source else b"",
            id=change_id,
            who=who,
        )


def prepare_description(site: Site, source: str) -> PreparedDescription:
    """Make ready what takes long; any thread."""
    addresses = [channel.address for channel in site.channels()]
    if any(device.streams for device in site.devices.values()):
        # Here and not where the first camera is made: driving frames go on meanwhile.
        can_film()
    return PreparedDescription(site, source, dump_site(site), catalogue_of(site), addresses)


class CurrentDescription:
    """What every part goes by; `DescriptionReload` replaces it. Event loop only.

    Attributes:
        now: what counts.
        turn: how often it was replaced.
        renamed: by the channel's address in an earlier description of this run: its address now.

    """

    def __init__(self, begun: PreparedDescription) -> None:
        """Begin with this."""
        self.now = begun
        self.turn = 0
        self.renamed: dict[str, str] = {}

    def replace_description(self, after: PreparedDescription, renamed: dict[str, str]) -> None:
        """Go by another one from here on, with channels renamed."""
        # What was renamed twice is found by its first name, too.
        earlier = {old: renamed.get(new, new) for old, new in self.renamed.items()}
        self.renamed = {**earlier, **renamed}
        self.now = after
        self.turn += 1
