"""Messages from the hub to a page: how nights stand, and what of them is to be asked for anew."""

from __future__ import annotations

from talaia.wire.browser_messages.subjects import SiteMessage
from talaia.wire.gateway_messages.field_types import Count, Micros, Name
from talaia.wire.gateway_messages.relayed_fields import NightFields

__all__ = ["NightPlanUpdate", "NightUpdate", "ObservingRequestUpdate"]


class NightUpdate(NightFields, SiteMessage, frozen=True, kw_only=True, tag="night"):
    """How a site's night stands; told to a page that comes, and whenever it changes."""

    site: Name


class NightPlanUpdate(SiteMessage, frozen=True, kw_only=True, tag="night_plan"):
    """There is a new plan; what of it a person may see is asked for over HTTP.

    Attributes:
        made_us: when it was made (UTC).
        blocks: how many visits it has.

    """

    site: Name
    made_us: Micros
    blocks: Count


class ObservingRequestUpdate(SiteMessage, frozen=True, kw_only=True, tag="observing_request"):
    """Something of a request has changed; what it is is asked for over HTTP by who may see it."""

    site: Name
    request: Name
