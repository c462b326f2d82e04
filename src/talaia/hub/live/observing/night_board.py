"""How each site's night stands: what its gateway said last, shown to pages, and asked to change."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.hub.auth.tokens import new_token
from talaia.wire import browser as page
from talaia.wire.browser_messages.relay import relay_message
from talaia.wire.frames import NightArmRequest, NightDisarmRequest, NightPlan, NightState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.live.pages.page_connections import Browser, Browsers
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.model.observing.plan import WhyNot

__all__ = ["ANSWER_S", "NightBoard", "SiteNight"]

# A gateway answers at once whether it is armed (s).
ANSWER_S = 10.0


@dataclass(slots=True)
class SiteNight:
    """What a gateway has said of its night; it stays shown while the gateway is away.

    Attributes:
        state: none: it has not said.
        state_us: when it came (UTC).
        plan: none: it has none, or has not said.
        plan_us: when it came (UTC).
        why_not: of the plan, by request.

    """

    state: NightState | None = None
    state_us: int = 0
    plan: NightPlan | None = None
    plan_us: int = 0
    why_not: dict[str, WhyNot] = field(default_factory=dict)


class NightBoard:
    """The newest of each site."""

    def __init__(self, sites: Sites, browsers: Browsers, clock: Clock) -> None:
        """Show it to ``browsers``; ``clock`` dates what comes."""
        self._sites = sites
        self._browsers = browsers
        self._clock = clock
        self._nights: dict[str, SiteNight] = {}
        # Answers that somebody waits for, by the id that they asked with.
        self._asked: dict[str, asyncio.Future[NightState]] = {}

    def night_of(self, site: str) -> SiteNight:
        """Give what is known of a site's night."""
        return self._nights.setdefault(site, SiteNight())

    def greet(self, browser: Browser) -> None:
        """Tell a page that has just come how the nights stand that it may see."""
        for live in self._sites:
            night = self._nights.get(live.name)
            if night is None:
                continue
            if night.state is not None:
                browser.send_message(relay_message(page.NightUpdate, night.state, live.name))
            if night.plan is not None:
                browser.send_message(_plan_news(live.name, night))

    def handle_state(self, live: LiveSite, state: NightState) -> None:
        """A gateway says how its night stands; who armed it is one whom the hub has told it."""
        state = replace(state, armed_by=live.handed_down.known_name(state.armed_by))
        night = self.night_of(live.name)
        night.state, night.state_us = state, self._now_us()
        waiting = self._asked.pop(state.answer_to, None) if state.answer_to else None
        if waiting is not None and not waiting.done():
            waiting.set_result(state)
        self._browsers.broadcast_message(relay_message(page.NightUpdate, state, live.name))

    def handle_plan(self, live: LiveSite, plan: NightPlan) -> None:
        """A gateway says what it plans; pages are told that there is a plan, and ask for it."""
        night = self.night_of(live.name)
        night.plan, night.plan_us = plan, self._now_us()
        night.why_not = {reason.request: reason for reason in plan.why_not}
        self._browsers.broadcast_message(_plan_news(live.name, night))

    def requests_moved(self, site: str, requests: Sequence[int]) -> None:
        """Tell pages that requests have changed, by their ids alone."""
        for number in requests:
            self._browsers.broadcast_message(
                page.ObservingRequestUpdate(site=site, request=str(number))
            )

    async def ask_gateway(
        self, live: LiveSite, who: str, *, armed: bool, until: float = 0.0, why: str = ""
    ) -> NightState | None:
        """Ask a gateway to arm or disarm; give its answer, or None when none came in time.

        Args:
            live: the site, whose gateway is linked.
            who: the account that asks.
            armed: whether the night is to run by itself.
            until: it disarms itself then (s since the epoch, UTC); 0: until somebody does.
            why: of the end.

        """
        if live.link is None:
            return None
        asked = new_token()
        answer: asyncio.Future[NightState] = asyncio.get_running_loop().create_future()
        self._asked[asked] = answer
        live.link.send(
            NightArmRequest(id=asked, who=who, until=until)
            if armed
            else NightDisarmRequest(id=asked, who=who, why=why)
        )
        try:
            async with asyncio.timeout(ANSWER_S):
                return await answer
        except TimeoutError:
            return None
        finally:
            self._asked.pop(asked, None)

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _plan_news(site: str, night: SiteNight) -> page.NightPlanUpdate:
    plan = night.plan.plan if night.plan is not None else None
    return page.NightPlanUpdate(
        site=site,
        made_us=round(plan.made_at * 1e6) if plan is not None else 0,
        blocks=len(plan.blocks) if plan is not None else 0,
    )
