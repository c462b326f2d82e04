"""Driving and STOP by clients of other tools, which cannot echo a gateway's time marks. Pure.

What such a client publishes to a driven topic is refused with the reason, unless an admin lets that
account drive that device. Then the lease is held for it here, and each message is one frame: good
for 250 ms from its arrival, at no more than half of the speed, and followed by zeros. STOP is
always theirs to press, and is repeated until the gateway has it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from talaia.clock import MS, SECOND
from talaia.wire.browser import (
    LeaseUpdate,
    PageDrive,
    PageLease,
    PageStop,
    StopUpdate,
    TickUpdate,
)
from talaia.wire.frames import LeaseOp

if TYPE_CHECKING:
    from talaia.model.site import Drive
    from talaia.wire.browser import FromBrowser, RequestError, ToBrowser

__all__ = ["GOOD_NS", "SPEED_SHARE", "ClientDriving"]

# A message moves the device for so long from its arrival.
GOOD_NS = 250 * MS
# Of the description's limits: how old such a client's line makes its messages is not known.
SPEED_SHARE = 0.5
# A lease that is held for a client is renewed, and given back when it has been silent for so long.
_RENEW_NS = SECOND
_IDLE_NS = 3 * SECOND
# One that was refused is asked for again after so long, if the client still publishes.
_ASK_AGAIN_NS = SECOND
# Zeros after the last message, and how far apart: as a page sends when a key is let go.
_ZEROS = 3
_ZERO_EVERY_NS = 50 * MS
# STOP is repeated so often, and so many times at the most: an answer may never come.
_STOP_EVERY_NS = 250 * MS
_MOST_STOPS = 40


class AsksHub(Protocol):
    """Passes a request on if the account has the right; else says why not."""

    def __call__(self, message: FromBrowser, /) -> RequestError | None:
        """Give the refusal, or none."""
        ...


class PermitsDriving(Protocol):
    """Whether an admin lets the account drive a device by such clients, now."""

    def __call__(self, device: str, /) -> bool:
        """Tell it of one device of the site."""
        ...


@dataclass(slots=True)
class _Hold:
    """One device that the client publishes velocities for; times are monotonic ns."""

    # When the newest message came, what it asks for (within the limits), and whether it has gone.
    arrived_ns: int
    linear: float = 0.0
    angular: float = 0.0
    lateral: float = 0.0
    sent: bool = False
    # Of the lease; 0 while it is not held.
    epoch: int = 0
    seq: int = 0
    # Long enough ago that the first is asked for at once.
    asked_ns: int = -_ASK_AGAIN_NS
    renewed_ns: int = 0
    # Why the lease was not given; empty: it was, or no answer has come.
    refused: str = ""
    # Frames were sent and no zero since; zeros that are still to go, and when the next one does.
    moving: bool = False
    zeros: int = 0
    zero_ns: int = 0


@dataclass(slots=True)
class _Pressed:
    """A STOP that the gateway has not answered."""

    device: str
    again_ns: int
    times: int = 1


class ClientDriving:
    """What one client drives at one site. Call `step` at `due_ns`, `observe_news` with news."""

    def __init__(self, site: str, *, ask: AsksHub, permits: PermitsDriving) -> None:
        """Drive devices of ``site`` for an account, by what ``permits`` says at each message."""
        # Messages of other sites come too, and are passed over.
        self._site = site
        # Each request passes the account's rights once more.
        self._ask = ask
        self._permits = permits
        # By device.
        self._holds: dict[str, _Hold] = {}
        # By the STOP's id.
        self._stops: dict[str, _Pressed] = {}
        # The gateway's newest mark, and when it was heard; -1 before the first.
        self._tick = -1
        self._tick_ns = 0

    def publish_velocity(
        self,
        device: str,
        rule: Drive | None,
        *,
        linear: float,
        angular: float,
        lateral: float = 0.0,
        now_ns: int,
    ) -> str:
        """Take one message of the client; say why it is refused, empty when it is not.

        Args:
            device: of the site.
            rule: the device's ``drive``; none of a device that is not driven.
            linear: forward (m/s).
            angular: counter-clockwise (rad/s).
            lateral: to the left (m/s); nothing comes of it on a base that cannot.
            now_ns: monotonic.

        """
        if not math.isfinite(linear + angular + lateral):
            return "a velocity must be a finite number"
        if rule is None:
            return f"{device or 'this'} is nothing that is driven"
        if rule.message.steers or rule.message.jogs:
            return f"{device} is driven by {rule.message}, which Talaia's own pages alone send"
        if not self._permits(device):
            self._let_go(device, now_ns)
            return (
                f"{device} is driven from Talaia's own pages only; an admin may let your account"
                " drive it by other clients (Admin, Clients)"
            )
        hold = self._holds.setdefault(device, _Hold(arrived_ns=now_ns))
        # Cut, not scaled: a client that asks for little gets what it asks.
        hold.linear = min(max(linear, -rule.reverse * SPEED_SHARE), rule.max_speed * SPEED_SHARE)
        aside = rule.max_sideways * SPEED_SHARE
        hold.lateral = min(max(lateral, -aside), aside)
        turn = rule.max_turn * SPEED_SHARE
        hold.angular = min(max(angular, -turn), turn)
        hold.arrived_ns, hold.sent, hold.zeros = now_ns, False, 0
        if hold.epoch:
            return self._send(device, hold, now_ns)
        if now_ns - hold.asked_ns < _ASK_AGAIN_NS:
            return hold.refused
        hold.asked_ns, hold.refused = now_ns, ""
        problem = self._ask(PageLease(site=self._site, device=device, op=LeaseOp.TAKE))
        if problem is not None:
            hold.refused = problem.message
        return hold.refused

    def release_device(self, device: str, now_ns: int) -> None:
        """Stop a device, and give its lease back; one that is not held is no matter."""
        self._let_go(device, now_ns)

    def press_stop(self, device: str, press: str, now_ns: int) -> str:
        """Press STOP (software) under an id of the caller's; say why not, if so."""
        # By the gate alone: an admin's word is for motion.
        problem = self._ask(PageStop(site=self._site, device=device, id=press))
        if problem is not None:
            return problem.message
        self._stops[press] = _Pressed(device, now_ns + _STOP_EVERY_NS)
        return ""

    def observe_news(self, message: ToBrowser, now_ns: int) -> str:
        """Take news of the hub; give what the client should be told of its driving, if anything."""
        match message:
            case TickUpdate() if message.site == self._site:
                self._tick, self._tick_ns = message.tick, now_ns
                for device, hold in self._holds.items():
                    self._catch_up(device, hold, now_ns)
            case LeaseUpdate() if message.site == self._site and message.device in self._holds:
                return self._observe_lease(message, now_ns)
            case StopUpdate():
                self._stops.pop(message.id, None)
            case _:
                pass
        return ""

    def due_ns(self) -> int | None:
        """Give when `step` wants to be called next (monotonic), or none."""
        # Whatever is soonest; `step` looks at each by itself.
        times = [pressed.again_ns for pressed in self._stops.values()]
        for hold in self._holds.values():
            times.append(hold.arrived_ns + _IDLE_NS)
            if hold.moving:
                times.append(hold.arrived_ns + GOOD_NS)
            if hold.zeros:
                times.append(hold.zero_ns)
            if hold.epoch:
                times.append(hold.renewed_ns + _RENEW_NS)
        return min(times, default=None)

    def step(self, now_ns: int) -> None:
        """Do what is due: zeros after the last message, renewals, leases given back, STOP again."""
        for press, pressed in list(self._stops.items()):
            if now_ns >= pressed.again_ns:
                self._press_again(press, pressed, now_ns)
        for device, hold in list(self._holds.items()):
            if hold.moving and now_ns >= hold.arrived_ns + GOOD_NS:
                hold.moving, hold.zeros, hold.zero_ns = False, _ZEROS, now_ns
            if hold.zeros and now_ns >= hold.zero_ns:
                hold.zeros, hold.zero_ns = hold.zeros - 1, now_ns + _ZERO_EVERY_NS
                self._drive(device, hold, zero=True, now_ns=now_ns)
            if now_ns >= hold.arrived_ns + _IDLE_NS:
                self._let_go(device, now_ns)
            elif hold.epoch and now_ns >= hold.renewed_ns + _RENEW_NS:
                hold.renewed_ns = now_ns
                self._ask(PageLease(site=self._site, device=device, op=LeaseOp.RENEW))

    def _observe_lease(self, message: LeaseUpdate, now_ns: int) -> str:
        device = message.device
        hold = self._holds[device]
        # The answer to this client alone: others are not told of it.
        if message.refused:
            hold.refused = message.refused
            return f"{device}: {message.refused}"
        if not message.yours:
            if not hold.epoch:
                return ""
            # Whoever has it now, the next message asks for it anew.
            del self._holds[device]
            return f"{device}: control went to {message.holder or 'nobody'}"
        # Renewals repeat the epoch; another one counts its frames from the start.
        if message.epoch != hold.epoch:
            hold.epoch, hold.seq = message.epoch, 0
            hold.renewed_ns, hold.refused = now_ns, ""
        if message.rival:
            # A person at a page asks: no tool can be asked, and the change passes through zero.
            self._ask(PageLease(site=self._site, device=device, op=LeaseOp.ACCEPT))
            return f"{device}: control is handed over to {message.rival}"
        self._catch_up(device, hold, now_ns)
        return ""

    def _catch_up(self, device: str, hold: _Hold, now_ns: int) -> None:
        """Send what came before the lease was given, while it is good."""
        if hold.epoch and not hold.sent and now_ns < hold.arrived_ns + GOOD_NS:
            self._send(device, hold, now_ns)

    def _send(self, device: str, hold: _Hold, now_ns: int) -> str:
        # Before the gateway's first mark no frame could be judged; the mark comes in 50 ms.
        if self._tick < 0:
            return ""
        hold.sent = hold.moving = True
        return self._drive(device, hold, now_ns=now_ns)

    def _drive(self, device: str, hold: _Hold, *, zero: bool = False, now_ns: int) -> str:
        if not hold.epoch or self._tick < 0:
            return ""
        hold.seq += 1
        problem = self._ask(
            PageDrive(
                site=self._site,
                device=device,
                epoch=hold.epoch,
                seq=hold.seq,
                tick=self._tick,
                held_ms=(now_ns - self._tick_ns) / MS,
                linear=0.0 if zero else hold.linear,
                angular=0.0 if zero else hold.angular,
                lateral=0.0 if zero else hold.lateral,
            )
        )
        return "" if problem is None else problem.message

    def _let_go(self, device: str, now_ns: int) -> None:
        """Stop and give the lease back, if it is held."""
        hold = self._holds.pop(device, None)
        if hold is None or not hold.epoch:
            return
        # The gateway stops it in any case when the lease is free.
        if hold.moving or hold.zeros:
            self._drive(device, hold, zero=True, now_ns=now_ns)
        self._ask(PageLease(site=self._site, device=device, op=LeaseOp.FREE))

    def _press_again(self, press: str, pressed: _Pressed, now_ns: int) -> None:
        if pressed.times >= _MOST_STOPS:
            del self._stops[press]
            return
        pressed.times += 1
        pressed.again_ns = now_ns + _STOP_EVERY_NS
        self._ask(PageStop(site=self._site, device=pressed.device, id=press))
