"""The lease of one device as it is spoken about: asks, answers, and what is written down. Pure.

Everything that gives the lease to another, or to nobody, ends in `changed`, once: there the
controller brings the vehicle to rest before anybody drives it again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.clock import MS
from talaia.gateway.driving.lease import DeviceLease
from talaia.wire.frames import LeaseForceRequest, LeaseOp, LeaseState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.driving.lease import LeaseHolder, LeaseRival
    from talaia.gateway.ports import ControlOutput
    from talaia.wire.frames import LeaseRequest

__all__ = ["LeaseProtocol"]


class OnHolderChange(Protocol):
    """Called when the lease went from one holder to another or to nobody, before it is told."""

    def __call__(self, now_ns: int, why: str, *, over: bool) -> None:
        """End what the former holder did; ``over`` when somebody else has it now."""
        ...


class LeaseProtocol:
    """Who has one device, who asks for it, and all that is said about it."""

    def __init__(
        self,
        *,
        device: str,
        duration_ns: int,
        next_epoch: Callable[[], int],
        output: ControlOutput,
        changed: OnHolderChange,
    ) -> None:
        """Start with nobody. For ``duration_ns`` and ``next_epoch`` see `DeviceLease`."""
        # All decisions; this class only speaks of them.
        self.lease = DeviceLease(duration_ns, next_epoch)
        self._device = device
        self._output = output
        # The controller's: brings the vehicle to rest when the holder changes.
        self._changed = changed
        # Who was last told to have it, and to ask for it: what time alone has changed since is
        # found by comparing.
        self._had: LeaseHolder | None = None
        self._asks: LeaseRival | None = None

    def on_ask(self, ask: LeaseRequest | LeaseForceRequest, now_ns: int) -> None:
        """Act on what a session wants, and answer it.

        Raises:
            OSError: a new epoch could not be kept on disk; nobody has got anything.

        """
        # What time has done by itself comes first, and is told as that.
        self.settle_due(now_ns)
        refused = self._apply_request(ask, now_ns)
        if refused:
            # A renewal that came too late is told, not recorded: each page does that once when it
            # wakes.
            taking = isinstance(ask, LeaseForceRequest) or ask.op is not LeaseOp.RENEW
            if taking:
                self._record_event("lease_refused", refused, ask.who)
            forceable = self.lease.may_force(ask.session, now_ns)
            self._output.send(self.lease_state(now_ns, ask.session, refused, forceable=forceable))
        else:
            self._output.send(self.lease_state(now_ns, ask.session))

    def _apply_request(self, ask: LeaseRequest | LeaseForceRequest, now_ns: int) -> str:
        lease, held = self.lease, self.lease.holder_at(now_ns)
        if isinstance(ask, LeaseForceRequest):
            refused = lease.force_lease(ask.session, ask.who, now_ns)
            if not refused and held is not None:
                self._record_event("lease_forced", f"from {held.who}", ask.who)
            return refused or self._record_given(now_ns, "control was taken by force")
        match ask.op:
            case LeaseOp.TAKE:
                return lease.take_lease(ask.session, ask.who, now_ns) or self._record_given(
                    now_ns, "taken anew"
                )
            case LeaseOp.ASK:
                return lease.request_lease(ask.session, ask.who, now_ns) or self._record_asked(
                    now_ns
                )
            case LeaseOp.ACCEPT:
                refused = lease.accept_rival(ask.session, now_ns)
                return refused or self._record_given(now_ns, "control was handed over")
            case LeaseOp.DENY:
                self._record_denied(now_ns, lease.deny_rival(ask.session, now_ns), ask.who)
            case LeaseOp.RENEW:
                return lease.renew_lease(ask.session, now_ns)
            case LeaseOp.FREE:
                if lease.free_lease(ask.session, now_ns):
                    self._record_event("lease_freed", "", ask.who)
                # Who freed it may have been the one who asked; that ask is withdrawn, not
                # unanswered.
                self._asks = lease.rival_at(now_ns)
                self.settle_due(now_ns, "lease given back")
        return ""

    def _record_given(self, now_ns: int, why: str) -> str:
        self._asks = self.lease.rival_at(now_ns)
        self._compare_holder(now_ns, why)
        return ""

    def _record_asked(self, now_ns: int) -> str:
        rival = self.lease.rival_at(now_ns)
        if rival is None:
            return self._record_given(now_ns, "taken anew")
        if rival != self._asks:
            held = self.lease.holder_at(now_ns)
            self._record_event("lease_asked", f"of {held.who}" if held else "", rival.who)
        self._asks = rival
        return ""

    def _record_denied(self, now_ns: int, rival: LeaseRival | None, who: str) -> None:
        if rival is not None:
            self._asks = None
            # Set before the states go out, so that `settle_due` does not tell it again as
            # unanswered.
            self._record_event("lease_denied", f"to {rival.who}", who)
            self._in_vain(now_ns, rival, f"{who} keeps control")

    def _in_vain(self, now_ns: int, rival: LeaseRival, why: str) -> None:
        self._output.send(self.lease_state(now_ns))
        self._output.send(self.lease_state(now_ns, rival.session, why, forceable=True))

    def settle_due(self, now_ns: int, why: str = "lease ended") -> None:
        """Do what time has decided: a lease that ran out, an ask that nobody answered."""
        lease = self.lease
        # Read before `holder`: reading the rival is what turns an overdue ask into one in vain.
        asked, self._asks = self._asks, lease.rival_at(now_ns)
        held = lease.holder_at(now_ns)
        if held is None and why == "lease ended" and self._had is not None:
            self._record_event("lease_ended", "not renewed", self._had.who)
        # The only place where time gives a lease to somebody; without the disk they get none, and
        # the ask is dropped, or each step would try the disk again.
        try:
            passed = lease.pass_on(now_ns)
        except OSError as error:
            lease.withdraw_rival()
            self._record_event("lease_refused", f"the gateway cannot write its disk: {error}", "")
            passed = False
        if passed:
            self._asks = None
        if self._compare_holder(now_ns, why):
            self._output.send(self.lease_state(now_ns))
        elif asked is not None and self._asks is None and held is not None:
            self._record_event("lease_unanswered", f"by {held.who}", asked.who)
            self._in_vain(now_ns, asked, f"{held.who} has not answered")

    def _compare_holder(self, now_ns: int, why: str) -> bool:
        """Tell the controller, once, that another has the lease, the same one anew, or nobody."""
        had, held = self._had, self.lease.holder_at(now_ns)
        self._had = held
        # By epoch: a session that took its lease anew counts as changed, a renewal does not.
        if (had and had.epoch) == (held and held.epoch):
            return False
        # `over`: straight from one driver to another, where the vehicle stands for a moment
        # between.
        over = had is not None and held is not None and had.session != held.session
        self._changed(now_ns, why, over=over)
        if held is not None:
            came = f"from {had.who}: {why}" if over and had is not None else ""
            self._record_event("lease_granted", came, held.who)
        return True

    def end_lease(self) -> None:
        """End it whoever has it or asks for it; the controller has seen to the vehicle."""
        # Forgotten as told, too: otherwise `settle_due` would record an end that the caller has
        # recorded.
        self.lease.drop_lease()
        self._had = self._asks = None

    def lease_state(
        self, now_ns: int, asked: str = "", refused: str = "", *, forceable: bool = False
    ) -> LeaseState:
        """Say who holds the device and who asks for it."""
        held, rival = self.lease.holder_at(now_ns), self.lease.rival_at(now_ns)
        if held is None:
            return LeaseState(device=self._device, asked=asked, refused=refused)
        return LeaseState(
            device=self._device,
            session=held.session,
            who=held.who,
            epoch=held.epoch,
            # Remaining time, no moment: page and gateway share no clock.
            remains_ms=max(0, (held.until_ns - now_ns) // MS),
            rival="" if rival is None else rival.session,
            rival_who="" if rival is None else rival.who,
            rival_ms=0 if rival is None else max(0, (rival.until_ns - now_ns) // MS),
            asked=asked,
            refused=refused,
            forceable=forceable,
        )

    def _record_event(self, kind: str, message: str, who: str) -> None:
        self._output.record_event(kind, self._device, message, who, good=True)
