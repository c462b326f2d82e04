"""STOP at gateways that wait while another one with their key has the place.

Either may be the one that moves the robot, so STOP goes down to all, and pages see how far it got
at each. What those that wait say of it is their own word, and changes nothing of the site's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire import browser as page, frames

if TYPE_CHECKING:
    from talaia.hub.live.pages.page_connections import Browser, Browsers
    from talaia.hub.live.site_state import HeldGateway
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit

__all__ = ["HeldStops"]


class HeldStops:
    """Sends STOP to those that wait, and tells pages what they answer."""

    def __init__(self, browsers: Browsers, audit: Audit) -> None:
        """Tell all of ``browsers`` that may see the device; write answers in ``audit``."""
        self._browsers = browsers
        # Not charged to the site: what a thief says must not cost its gateway anything.
        self._audit = audit

    def send_stop(self, live: LiveSite, stop: frames.StopRequest) -> None:
        """Send a STOP to all that wait for the place of a site."""
        told = False
        for held in live.rivals.held:
            # Each time that the page repeats it, as it goes to the linked one.
            held.link.send(stop)
            # A page repeats it until the linked one answers; they are told of it once.
            if held.pressed.get(stop.device) != stop.id:
                told = True
                held.pressed[stop.device] = stop.id
                held.written.pop(stop.device, None)
        if told:
            self._browsers.broadcast_message(_held_news(live, stop.device))

    def receive_state(self, live: LiveSite, held: HeldGateway, state: frames.StopState) -> None:
        """Keep how one that waits says that STOP stands; only where it was asked for."""
        if state.device not in held.pressed:
            return
        # To know what is new: a beat brings it again and again.
        before = held.stops.get(state.device)
        held.stops[state.device] = state
        said = (state.latched, state.confirmed)
        if before is not None and said == (before.latched, before.confirmed):
            return
        self._browsers.broadcast_message(_held_news(live, state.device))
        reached = state.latched + (state.latched and state.confirmed)
        if reached <= held.written.get(state.device, 0):
            # Going to and fro writes nothing, for a thief would fill the log with it.
            return
        held.written[state.device] = reached
        self._audit.append_record(
            "second gateway: " + ("stop latched", "stop confirmed by the robot")[reached - 1],
            # In nobody's name: it could give any.
            site=live.name,
            device=state.device,
            message=held.address,
            source="gateway",
        )

    def forget_gateway(self, live: LiveSite, held: HeldGateway) -> None:
        """Tell pages that one waits no longer; it is out of the site's list already."""
        for device in held.pressed:
            self._browsers.broadcast_message(_held_news(live, device))

    def greet(self, live: LiveSite, browser: Browser) -> None:
        """Tell a page that has just come."""
        for device in {device for held in live.rivals.held for device in held.pressed}:
            browser.send_message(_held_news(live, device))


def _held_news(live: LiveSite, device: str) -> page.HeldStopUpdate:
    asked = [held for held in live.rivals.held if device in held.pressed]
    states = [held.stops[device] for held in asked if device in held.stops]
    return page.HeldStopUpdate(
        site=live.name,
        device=device,
        id=asked[-1].pressed[device] if asked else "",
        held=len(asked),
        latched=sum(state.latched for state in states),
        confirmed=sum(state.latched and state.confirmed for state in states),
    )
