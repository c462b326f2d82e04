"""How each message of a page is tried: about an object, and what it lets reach the gateway."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.wire import browser, frames
from talaia.wire.frames import LeaseOp

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.wire.shape import Message

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
    browser.Ping: Trial(lambda *_about: browser.Ping(n=1, at_ms=0.0), ("",)),
    browser.Lease: Trial(
        lambda site, device, _mark: browser.Lease(site=site, device=device, op=LeaseOp.TAKE),
        DEVICES,
        frames.LeaseAsk,
    ),
    browser.Drive: Trial(
        lambda site, device, _mark: browser.Drive(
            site=site, device=device, epoch=1, seq=1, tick=1, linear=0.5, angular=0.0
        ),
        DEVICES,
        frames.Drive,
    ),
    browser.Stop: Trial(
        lambda site, device, mark: browser.Stop(site=site, device=device, id=mark),
        DEVICES,
        frames.StopAsk,
    ),
    browser.Reset: Trial(
        lambda site, device, _mark: browser.Reset(site=site, device=device, epoch=1),
        DEVICES,
        frames.ResetAsk,
    ),
    browser.Command: Trial(
        lambda site, device, mark: browser.Command(
            site=site, device=device, command="turn", id=mark
        ),
        DEVICES,
        frames.CommandAsk,
    ),
    browser.LeaseForce: Trial(
        lambda site, device, _mark: browser.LeaseForce(site=site, device=device),
        DEVICES,
        frames.LeaseForce,
    ),
    browser.Cancel: Trial(
        lambda site, device, mark: browser.Cancel(site=site, device=device, id=mark),
        DEVICES,
        frames.CommandCancel,
    ),
    browser.Override: Trial(
        lambda site, _device, mark: browser.Override(
            site=site, interlock="lock", reason=mark, seconds=1.0
        ),
        SITES,
        frames.OverrideAsk,
    ),
}
# What a gateway is asked to do for people; the rest it is told anyway.
ASKS = (
    frames.LeaseAsk,
    frames.LeaseForce,
    frames.Drive,
    frames.StopAsk,
    frames.ResetAsk,
    frames.CommandAsk,
    frames.CommandCancel,
    frames.OverrideAsk,
)
