"""Driving by single characters: which vehicle, and what `s` means. Pure but for its connection."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.key_velocity import key_velocity
from talaia.hub.clients.socketio.founding_words import STOP_WORD
from talaia.wire.browser import LeaseUpdate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.socketio.offer import SocketioOffer
    from talaia.wire.browser import ToBrowser

__all__ = ["ControlKeys"]

_STANDSTILL = "s"


class ControlKeys:
    """What one client drives."""

    def __init__(self, connection: ClientConnection, vehicle: str) -> None:
        """Drive through ``connection``; ``vehicle`` is the one that was asked for, if any."""
        self._connection = connection
        self._vehicle = vehicle
        # Driven devices that somebody else has control of.
        self._with_others: set[str] = set()

    def observe_news(self, message: ToBrowser) -> None:
        """Keep who has control of what."""
        if isinstance(message, LeaseUpdate) and message.site == self._connection.live.name:
            if message.holder and not message.yours:
                self._with_others.add(message.device)
            else:
                self._with_others.discard(message.device)

    def press_key(self, key: str, offer: SocketioOffer) -> str:
        """Do what a character or the word ``stop`` asks; say why not, if so."""
        if key == STOP_WORD:
            return self._press_stop(offer)
        device = self._choose_device(offer)
        if not device:
            # Whoever may not drive, or has not said what, may still want it to stand.
            return self._press_stop(offer) if key == _STANDSTILL else self._why_none(offer.driven)
        # A zero of ours would take control from who has it, and not stop what they drive.
        if key == _STANDSTILL and device in self._with_others:
            return self._press_stop(offer)
        rule = self._connection.description.devices[device].drive
        if rule is None:
            return self._why_none(offer.driven)
        velocity = key_velocity(key, rule)
        if isinstance(velocity, str):
            return velocity
        why = self._connection.publish_drive(
            device, linear=velocity.linear, angular=velocity.angular
        )
        if why and key == _STANDSTILL:
            return self._press_stop(offer)
        return why

    def _choose_device(self, offer: SocketioOffer) -> str:
        if self._vehicle:
            return self._vehicle if self._vehicle in offer.driven else ""
        allowed = [name for name in offer.driven if self._connection.may_drive(name)]
        # Without an admin's word for any, the one that there is gives the reason.
        chosen = allowed or list(offer.driven)
        return chosen[0] if len(chosen) == 1 else ""

    def _press_stop(self, offer: SocketioOffer) -> str:
        device = self._choose_device(offer)
        if not device:
            wanted = [name for name in offer.stopped if self._vehicle in {"", name}]
            if len(wanted) != 1:
                return self._why_none(offer.stopped)
            device = wanted[0]
        return self._connection.press_stop(device)[1]

    def _why_none(self, choice: Sequence[str]) -> str:
        if not choice:
            return "there is nothing here that this account may drive or stop"
        names = ", ".join(choice)
        if self._vehicle:
            return f"there is no vehicle {self._vehicle!r} for this account; there are: {names}"
        return f"put the vehicle that is meant into the address, vehicle=…; there are: {names}"
