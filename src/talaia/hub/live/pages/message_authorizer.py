"""The one gate that every message between hub and browser passes, inbound and outbound."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.hub.auth.permissions import sees_stream
from talaia.hub.policy import (
    FROM_BROWSER,
    TO_BROWSER,
    AccessNeed,
    allows,
    need_of_message,
)
from talaia.wire.browser import PageLease, PageStop, RequestError, Subscribe
from talaia.wire.browser_messages.subjects import StreamMessage
from talaia.wire.frames import LeaseOp

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import Sites
    from talaia.wire.browser import FromBrowser, ToBrowser

__all__ = ["STORE", "MessageAuthorizer"]

# Of a problem that ends by itself: who may do what is not known just now.
STORE = "store"
_UNSURE = "the hub's database does not answer; only STOP is passed on"
_UNSURE_SUBSCRIBED = "the hub's database does not answer; values follow by themselves when it does"


class KnowsRights(Protocol):
    """Whoever checks the sessions of those who have a socket open."""

    @property
    def sure(self) -> bool:
        """Whether it was known a moment ago who may do what."""
        ...


class MessageAuthorizer:
    """Holds messages against the policy table and the person's rights."""

    def __init__(self, *, sites: Sites, rights: KnowsRights) -> None:
        """Look objects up in ``sites``; ``rights`` tells whether they are known just now."""
        self._sites = sites
        self._rights = rights

    def refusal(self, grants: Grants, message: FromBrowser) -> RequestError | None:
        """Say why a message from a browser is refused; None when it may pass.

        What a person may not see is told like what does not exist.
        """
        need = need_of_message(FROM_BROWSER, message)
        site, device, _ = message.subject()
        live = self._sites.find_site(site) if site else None
        described = live.description if live else None
        tag = str(type(message).__struct_config__.tag)
        if allows(need, grants, described, device):
            # Rights of before are not trusted for long, but STOP and letting go need no trust.
            if need is AccessNeed.SESSION or self._rights.sure or _makes_safe(message):
                return None
            return RequestError(
                code=STORE,
                message=_UNSURE_SUBSCRIBED if isinstance(message, Subscribe) else _UNSURE,
                about=tag,
            )
        # Whoever may not even see it must not learn that it is there.
        if need is not AccessNeed.NEVER and not allows(AccessNeed.SEE, grants, described, device):
            what = f"device {device!r} at site {site!r}" if device else f"site {site!r}"
            return RequestError(code="unknown", message=f"there is no {what}", about=tag)
        return RequestError(
            code="forbidden", message="you do not have the right to do this", about=tag
        )

    def may_get(self, grants: Grants, message: ToBrowser) -> bool:
        """Tell whether a message may be sent to a person."""
        need = need_of_message(TO_BROWSER, message)
        if need is AccessNeed.SESSION:
            return True
        site, device, stream = message.subject()
        live = self._sites.find_site(site)
        described = live.description if live else None
        if isinstance(message, StreamMessage):
            # What a camera saw is like its pictures themselves.
            return described is not None and sees_stream(grants, described, device, stream)
        return allows(need, grants, described, device)


def _makes_safe(message: FromBrowser) -> bool:
    """Tell whether a message may pass even when it is not known who may do what."""
    return isinstance(message, PageStop) or (
        isinstance(message, PageLease) and message.op is LeaseOp.FREE
    )
