"""What gateways say of their nights, led to the part that it is for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire import frames

if TYPE_CHECKING:
    from talaia.hub.live.observing.night_board import NightBoard
    from talaia.hub.live.observing.night_notifier import NightNotifier
    from talaia.hub.live.observing.observation_intake import ObservationIntake
    from talaia.hub.live.observing.request_sender import RequestSender
    from talaia.hub.live.sites import LiveSite

__all__ = ["NightLink", "NightMessage"]

NightMessage = (
    frames.NightState | frames.NightPlan | frames.RequestRevision | frames.ObservationUpdate
)
# What a gateway writes down of its night begins so.
_EVENTS = "night_"


class NightLink:
    """The night's side of every link."""

    def __init__(
        self,
        *,
        board: NightBoard,
        sender: RequestSender,
        intake: ObservationIntake,
        notifier: NightNotifier,
    ) -> None:
        """Lead messages to these."""
        self._notifier = notifier
        self._board = board
        self._sender = sender
        self._intake = intake

    def handle_message(self, live: LiveSite, message: NightMessage) -> None:
        """Take a message of a site's gateway; never waits."""
        match message:
            case frames.NightState():
                self._board.handle_state(live, message)
            case frames.NightPlan():
                self._board.handle_plan(live, message)
            case frames.RequestRevision():
                self._sender.handle_revision(live, message.revision)
            case frames.ObservationUpdate():
                self._intake.handle_report(live, message)

    def handle_event(self, live: LiveSite, event: frames.Event) -> None:
        """Take what a gateway writes down, if it is of its night; never waits."""
        if event.kind.startswith(_EVENTS):
            self._notifier.handle_event(live, event)

    def link_lost(self, site: str) -> None:
        """A gateway is gone: nothing is known of which requests it has."""
        self._sender.link_lost(site)
