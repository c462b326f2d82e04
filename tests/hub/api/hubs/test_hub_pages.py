"""How hubs that are one stand, as their page says it."""

from __future__ import annotations

from talaia.clock import HandClock
from talaia.hub.api.hubs.hub_pages import HubPages
from talaia.hub.cluster.peers import HubNotice
from talaia.hub.files.local_folder import LocalFolder


class Seat:
    """A place among hubs that has heard what it is given, just now."""

    connected = True

    def __init__(self, own: HubNotice, *others: HubNotice, heard_ns: int) -> None:
        """Be ``own``, beside others."""
        self._own, self._others, self._heard_ns = own, others, heard_ns

    def own_notice(self) -> HubNotice:
        return self._own

    def heard_hubs(self) -> list[tuple[HubNotice, int]]:
        return [(notice, self._heard_ns) for notice in self._others]


def notice(name: str, epoch: int = 0) -> HubNotice:
    return HubNotice(hub=name, name=name, version="1", leads=epoch > 0, epoch=epoch)


async def test_a_lead_that_was_replaced_leads_no_more_though_it_was_just_heard(tmp_path) -> None:
    clock = HandClock()
    own, killed, third = notice("east", epoch=2), notice("west", epoch=1), notice("north")
    pages = HubPages(
        Seat(own, killed, third, heard_ns=clock.monotonic_ns()), clock, LocalFolder(tmp_path)
    )
    roles = {hub.name: hub.role for hub in (await pages.hubs()).hubs}
    assert roles == {"east": "leads", "west": "waits", "north": "waits"}
