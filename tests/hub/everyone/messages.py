"""How each message of a page is tried: about an object, and what it lets reach the gateway."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.wire import browser, frames
from talaia.wire.frames import LeaseOp

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.wire.message import Message

DEVICES = ("agv/base", "agv/power", "agv/camera", "moon/rover")
SITES = ("agv", "moon")


class Trial(NamedTuple):
    """A message about an object, with a mark by which it is known again."""

    make: Callable[[str, str, str], Message]
    objects: tuple[str, ...]
    # What reaches the gateway when it is let through; None when nothing does.
    reaches: type[Message] | None = None


TRIALS: Mapping[type[Message], Trial] = {
    browser.Subscribe: Trial(
        lambda site, _device, _mark: browser.Subscribe(sub=1, site=site, channels=[]), SITES
    ),
    browser.Unsubscribe: Trial(lambda *_about: browser.Unsubscribe(sub=1), ("",)),
    browser.PagePing: Trial(lambda *_about: browser.PagePing(n=1, at_ms=0.0), ("",)),
    browser.PageLease: Trial(
        lambda site, device, _mark: browser.PageLease(site=site, device=device, op=LeaseOp.TAKE),
        DEVICES,
        frames.LeaseRequest,
    ),
    browser.PageDrive: Trial(
        lambda site, device, _mark: browser.PageDrive(
            site=site, device=device, epoch=1, seq=1, tick=1, linear=0.5, angular=0.0
        ),
        DEVICES,
        frames.DriveFrame,
    ),
    browser.PageTwinDrive: Trial(
        lambda site, device, _mark: browser.PageTwinDrive(
            site=site, device=device, epoch=1, seq=1, tick=1, linear=0.5, angular=0.0, live=True
        ),
        DEVICES,
        frames.TwinFrame,
    ),
    browser.PageTwin: Trial(
        lambda site, device, _mark: browser.PageTwin(
            site=site, device=device, epoch=1, op=frames.TwinOp.LIVE
        ),
        DEVICES,
        frames.TwinRequest,
    ),
    browser.PageStop: Trial(
        lambda site, device, mark: browser.PageStop(site=site, device=device, id=mark),
        DEVICES,
        frames.StopRequest,
    ),
    browser.PageReset: Trial(
        lambda site, device, _mark: browser.PageReset(site=site, device=device, epoch=1),
        DEVICES,
        frames.ResetRequest,
    ),
    browser.PageCommand: Trial(
        lambda site, device, mark: browser.PageCommand(
            site=site, device=device, command="turn", id=mark
        ),
        DEVICES,
        frames.CommandRequest,
    ),
    browser.PageLeaseForce: Trial(
        lambda site, device, _mark: browser.PageLeaseForce(site=site, device=device),
        DEVICES,
        frames.LeaseForceRequest,
    ),
    browser.PageCommandCancel: Trial(
        lambda site, device, mark: browser.PageCommandCancel(site=site, device=device, id=mark),
        DEVICES,
        frames.CommandCancel,
    ),
    browser.PageOverride: Trial(
        lambda site, _device, mark: browser.PageOverride(
            site=site, interlock="lock", reason=mark, seconds=1.0
        ),
        SITES,
        frames.OverrideRequest,
    ),
}
# What a gateway is asked to do for people; the rest it is told anyway.
ASKS = (
    frames.LeaseRequest,
    frames.LeaseForceRequest,
    frames.DriveFrame,
    frames.TwinFrame,
    frames.TwinRequest,
    frames.StopRequest,
    frames.ResetRequest,
    frames.CommandRequest,
    frames.CommandCancel,
    frames.OverrideRequest,
)
