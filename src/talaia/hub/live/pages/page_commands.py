"""Leases, driving, STOP and one-shot commands: from a page down to the gateway.

The hub decides who may (the gate has done so before a message comes here) and the gateway
decides whether it is allowed now. Nothing is queued for a gateway that is away.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.hub.auth.permissions import Right
from talaia.hub.live.site_state import Pending
from talaia.model.arguments import fields_of, unit_problem
from talaia.model.interlocks.override_rules import longest_override
from talaia.model.site import CommandRight
from talaia.wire import browser as page, frames
from talaia.wire.frames import CommandPhase, LeaseOp

if TYPE_CHECKING:
    from talaia.hub.live.gateways.doubles.held_stops import HeldStops
    from talaia.hub.live.pages.page_connections import Browser
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.audit import Audit
    from talaia.model.interlocks.interlock import Interlock

__all__ = ["PageCommands"]

# Of one site: each waits for an answer that a gateway may never give.
_MOST_PENDING = 1000

Asked = (
    page.PageLease
    | page.PageLeaseForce
    | page.PageDrive
    | page.PageTwin
    | page.PageTwinDrive
    | page.PageStop
    | page.PageReset
    | page.PageCommand
    | page.PageCommandCancel
    | page.PageOverride
)


class PageCommands:
    """Passes on what people ask of a robot."""

    def __init__(self, sites: Sites, held_stops: HeldStops, audit: Audit) -> None:
        """Write down in ``audit`` who asked what; STOP goes by ``held_stops``, too."""
        self._sites = sites
        self._held_stops = held_stops
        self._audit = audit
        # What each page (by its key) has asked the lease of: site and device.
        self._asked: dict[str, set[tuple[str, str]]] = {}

    def ask(self, browser: Browser, asked: Asked) -> None:
        """Pass on what a page asks; answer at once when the gateway is away."""
        live = self._sites.find_site(asked.site)
        if live is None or live.link is None:
            self._refuse(browser, asked, "offline", f"{asked.site} is not connected")
            return
        match asked:
            case page.PageLease():
                # Before it is sent: a page that goes now must free what it may still get.
                if asked.op is not LeaseOp.FREE:
                    self._asked.setdefault(browser.key, set()).add((live.name, asked.device))
                live.link.send(_lease_ask(browser, asked.device, asked.op))
            case page.PageLeaseForce():
                self._asked.setdefault(browser.key, set()).add((live.name, asked.device))
                live.link.send(
                    frames.LeaseForceRequest(
                        device=asked.device, session=browser.key, who=browser.signature
                    )
                )
                self._append_record(live, "lease force asked", browser.signature, asked.device)
            case page.PageDrive():
                self._drive(browser, live, asked)
            case page.PageTwin():
                live.link.send(
                    frames.TwinRequest(
                        device=asked.device,
                        session=browser.key,
                        epoch=asked.epoch,
                        who=browser.signature,
                        op=asked.op,
                    )
                )
                said = f"twin {asked.op} asked"
                self._append_record(live, said, browser.signature, asked.device)
            case page.PageTwinDrive():
                self._drive_twin(browser, live, asked)
            case page.PageStop():
                stop = frames.StopRequest(device=asked.device, id=asked.id, who=browser.signature)
                live.link.send(stop)
                # Of two gateways with one key either may be the one that moves the robot.
                self._held_stops.send_stop(live, stop)
                # By its id the log joins the presses of a group, which begin alike.
                self._append_record(
                    live, "stop pressed", browser.signature, asked.device, message=asked.id
                )
            case page.PageReset():
                live.link.send(
                    frames.ResetRequest(
                        device=asked.device,
                        session=browser.key,
                        epoch=asked.epoch,
                        who=browser.signature,
                        token=asked.token,
                    )
                )
                # A first request without a token only asks for one.
                if asked.token:
                    self._append_record(live, "stop reset asked", browser.signature, asked.device)
            case page.PageCommand():
                self._command(browser, live, asked)
            case page.PageCommandCancel():
                live.link.send(
                    frames.CommandCancel(id=asked.id, device=asked.device, who=browser.signature)
                )
                self._append_record(
                    live, "cancel asked", browser.signature, asked.device, message=asked.id
                )
            case page.PageOverride():
                self._override(browser, live, asked)

    def leave(self, browser: Browser) -> None:
        """Free, at once, what a page that has gone was holding or was about to get."""
        # All that it ever asked for: freeing what it does not hold changes nothing.
        for site, device in self._asked.pop(browser.key, set()):
            live = self._sites.find_site(site)
            if live is not None and live.link is not None:
                live.link.send(_lease_ask(browser, device, LeaseOp.FREE))

    def _drive(self, browser: Browser, live: LiveSite, asked: page.PageDrive) -> None:
        # The gateway checks all of this again; what cannot be right is not even sent.
        # A sum is finite only if all of its parts are: NaN and infinities are refused.
        numbers = (asked.linear, asked.angular, asked.lateral, asked.steering, *asked.joints)
        if live.link is None or not math.isfinite(sum(numbers) + asked.held_ms):
            self._refuse(browser, asked, "invalid", "a driving frame holds plain numbers")
            return
        live.link.send(
            frames.DriveFrame(
                device=asked.device,
                session=browser.key,
                epoch=asked.epoch,
                seq=asked.seq,
                tick=asked.tick,
                held_ms=asked.held_ms,
                linear=asked.linear,
                angular=asked.angular,
                lateral=asked.lateral,
                steering=asked.steering,
                joints=asked.joints,
                picture_ms=asked.picture_ms,
            )
        )

    def _drive_twin(self, browser: Browser, live: LiveSite, asked: page.PageTwinDrive) -> None:
        # The gateway alone decides whether it reaches the robot.
        if live.link is None or not math.isfinite(asked.linear + asked.angular + asked.held_ms):
            self._refuse(browser, asked, "invalid", "a driving frame holds plain numbers")
            return
        live.link.send(
            frames.TwinFrame(
                device=asked.device,
                session=browser.key,
                epoch=asked.epoch,
                seq=asked.seq,
                tick=asked.tick,
                held_ms=asked.held_ms,
                linear=asked.linear,
                angular=asked.angular,
                picture_ms=asked.picture_ms,
                live=asked.live,
            )
        )

    def _override(self, browser: Browser, live: LiveSite, asked: page.PageOverride) -> None:
        rule = live.description.interlocks.get(asked.interlock)
        if rule is None or live.link is None:
            self._refuse(browser, asked, "unknown", f"there is no interlock {asked.interlock!r}")
            return
        if problem := _no_override(live, rule, asked):
            self._refuse(browser, asked, "invalid", problem)
            return
        who = browser.signature
        live.link.send(
            frames.OverrideRequest(
                interlock=asked.interlock,
                who=who,
                reason=asked.reason,
                seconds=asked.seconds,
                condition=asked.condition,
            )
        )
        named = f" ({asked.condition})" if asked.condition else ""
        said = f"{asked.interlock}{named} for {asked.seconds:g} s: {asked.reason}"
        self._append_record(live, "override asked", who, "", message=said)

    def _command(self, browser: Browser, live: LiveSite, asked: page.PageCommand) -> None:
        command = live.description.devices[asked.device].commands.get(asked.command)
        if command is None or live.link is None:
            self._refuse(browser, asked, "unknown", f"there is no command {asked.command!r}")
            return
        # Beyond what the policy table asks of all commands. Missions and other tools' clients come
        # this way, too.
        takes_admin = command.right is CommandRight.ADMIN
        if takes_admin and not browser.who.grants.has_right(Right.ADMIN, live.name, asked.device):
            problem = f"{command.name} needs the right {command.right} on this device"
            self._refuse(browser, asked, "forbidden", problem)
            return
        # The gateway checks it again, by its own copy of the description.
        fields = fields_of(command, asked.args)
        problem = fields if isinstance(fields, str) else unit_problem(command, asked.units)
        if problem:
            self._refuse(browser, asked, "invalid", problem)
            return
        # An id that comes twice is a repeat: the robot must not do it twice.
        if asked.id in live.current.pending or len(live.current.pending) >= _MOST_PENDING:
            self._refuse(browser, asked, "busy", "this command is under way already")
            return
        who = browser.signature
        # Before it is sent, so that an end that comes at once finds it.
        live.current.pending[asked.id] = Pending(asked.id, asked.device, asked.command, who)
        live.link.send(
            frames.CommandRequest(
                id=asked.id,
                device=asked.device,
                command=asked.command,
                args=asked.args,
                units=asked.units,
                over=asked.over,
                ttl_ms=command.ttl * 1000,
                who=who,
            )
        )
        said = ", ".join(f"{key}={value!r}" for key, value in asked.args.items())
        over = f" over {asked.over}" if asked.over else ""
        message = f"{asked.command}({said}) {asked.id}{over}"
        self._append_record(live, "command asked", who, asked.device, message=message)

    def _refuse(self, browser: Browser, asked: Asked, code: str, message: str) -> None:
        about = str(type(asked).__struct_config__.tag)
        browser.send_message(page.RequestError(code=code, message=message, about=about))
        # A page waits for the end of its command by id; a refusal is one too.
        if isinstance(asked, page.PageCommand):
            browser.send_message(
                page.CommandUpdate(
                    site=asked.site,
                    device=asked.device,
                    command=asked.command,
                    id=asked.id,
                    phase=CommandPhase.REFUSED,
                    message=message,
                    who=browser.signature,
                )
            )
        # Driving frames come many times a second: refusals of them would fill the log.
        if not isinstance(asked, page.PageDrive | page.PageTwinDrive):
            self._audit.append_record(
                f"{about} refused",
                who=browser.signature,
                site=asked.site,
                device=asked.subject().device,
                message=message,
                good=False,
            )

    def _append_record(
        self, live: LiveSite, kind: str, who: str, device: str, *, message: str = ""
    ) -> None:
        self._audit.append_record(kind, who=who, site=live.name, device=device, message=message)


def _lease_ask(browser: Browser, device: str, op: LeaseOp) -> frames.LeaseRequest:
    return frames.LeaseRequest(device=device, session=browser.key, who=browser.signature, op=op)


def _no_override(live: LiveSite, rule: Interlock, asked: page.PageOverride) -> str:
    """Say why an override is not even asked of the gateway, which judges it again."""
    longest = longest_override(rule)
    if asked.seconds > longest:
        if not longest:
            return f"{rule.name} may never be overridden"
        return f"{rule.name} may be overridden for at most {longest:g} s"
    # 0 s ends an override, and that is always allowed.
    if not asked.seconds:
        return ""
    if not asked.reason.strip():
        return "say why it is overridden"
    # The gateway judges again; this only answers sooner.
    known = live.current.interlocks.get(asked.interlock)
    if known is not None and not known[0].locked:
        return f"{rule.name} locks nothing now, so there is nothing to override"
    return "" if known is None else known[0].no_override
