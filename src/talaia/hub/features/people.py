"""People: accounts, roles, sessions, tokens, and who may open what."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.access import Access
from talaia.hub.api.accounts.authentication import Authentication
from talaia.hub.api.accounts.browser_sessions import BrowserSessions
from talaia.hub.api.accounts.displays import DisplayPages
from talaia.hub.api.accounts.oidc import OidcPages
from talaia.hub.api.accounts.oidc_sign_in import OidcSignIn
from talaia.hub.api.accounts.own_account import OwnPages
from talaia.hub.api.accounts.passkey_answers import PasskeyAnswers
from talaia.hub.api.accounts.passkeys import PasskeyPages
from talaia.hub.api.accounts.people import PeoplePages
from talaia.hub.api.accounts.roles import RolePages
from talaia.hub.api.accounts.sign_in import Accounts
from talaia.hub.api.accounts.tokens import TokenPages
from talaia.hub.api.rate_limits import RateLimits
from talaia.hub.api.sockets.gateway_admission import GatewayAdmission
from talaia.hub.api.sockets.socket_admission import SocketAdmission
from talaia.hub.auth.oidc_settings import read_oidc_settings
from talaia.hub.auth.passkey_challenges import PasskeyChallenges
from talaia.hub.auth.passwords import Passwords
from talaia.hub.auth.provider_client import ProviderClient
from talaia.hub.auth.throttle import Throttle
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.gateways.join_queue import JoinQueue
from talaia.hub.live.pages.session_registry import SocketSessions
from talaia.hub.store.accounts.account_list import AccountList
from talaia.hub.store.accounts.credentials import Credentials
from talaia.hub.store.accounts.displays import Displays
from talaia.hub.store.accounts.failed_logins import FailedLogins
from talaia.hub.store.accounts.identities import Identities
from talaia.hub.store.accounts.known_browsers import KnownBrowsers
from talaia.hub.store.accounts.mfa import SecondFactors
from talaia.hub.store.accounts.mission_accounts import MissionAccounts
from talaia.hub.store.accounts.passkeys import Passkeys
from talaia.hub.store.accounts.people import People
from talaia.hub.store.accounts.roles import Roles
from talaia.hub.store.accounts.sessions import Sessions
from talaia.hub.store.accounts.tokens import ApiTokens

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.site_registry import SiteRegistry

__all__ = ["PeopleFeature"]


class PeopleFeature(Feature):
    """Who is who, and what they may.

    Attributes:
        accounts: everyone who may sign in.
        sessions: who is signed in.
        tokens: what scripts sign in with.
        displays: screens that show some sites.
        mission_accounts: with whose rights missions run.
        seats: the sockets that people have open.
        access: guards every route by the policy table.
        limits: how much each may ask.
        admission: lets sockets in.
        proving: checks what people know and have.
        setup_token: opens the set-up page; set after the start when there are no people yet.

    """

    name = "people"

    def __init__(self, core: Core, *, audit: Audit, registry: SiteRegistry) -> None:
        """Gateways are known by ``registry``."""
        settings, database, clock = core.settings, core.database, core.clock
        # How often sessions are checked, and how long the set-up link is good.
        self._settings = settings
        self._is_main = core.shard.is_main
        self.setup_token: str | None = None
        self.accounts = People(database, clock)
        self.sessions = Sessions(database, clock, settings)
        self.tokens = ApiTokens(database, clock)
        self.displays = Displays(database, clock)
        self.mission_accounts = MissionAccounts(database)
        credentials = Credentials(self.sessions, self.tokens, self.displays, self.mission_accounts)
        self.seats = SocketSessions(credentials, clock, settings)
        self.access = Access(
            sessions=self.sessions,
            tokens=self.tokens,
            displays=self.displays,
            sites=core.sites,
            settings=settings,
        )
        self.limits = RateLimits(clock)
        self.admission = self._build_admission(core, registry)
        # Brought back at the start: a restart must give nobody new tries.
        self._tries = FailedLogins(database, clock, Throttle())
        factors = SecondFactors(database, clock, core.secret_box)
        passwords = Passwords(settings.password_cost)
        sessions = BrowserSessions(
            access=self.access,
            sessions=self.sessions,
            browsers=KnownBrowsers(database, clock),
            seats=self.seats,
        )
        # Told by whoever delivers how to wake it, which is built after this.
        self.proving = proving = Authentication(
            sessions=sessions,
            people=self.accounts,
            passwords=passwords,
            factors=factors,
            tries=self._tries,
            audit=audit,
        )
        answers, passkey_pages = self._build_passkeys(core, sessions, factors, audit)
        roster = AccountList(database, self.sessions)
        others = (
            self._build_oidc_pages(core, sessions, roster, audit),
            TokenPages(tokens=self.tokens, seats=self.seats, audit=audit, clock=clock),
            self._build_displays(core, audit),
            RolePages(roles=Roles(database), seats=self.seats, audit=audit),
        )
        pages = (
            Accounts(
                proving=proving,
                sessions=sessions,
                people=self.accounts,
                passwords=passwords,
                audit=audit,
            ),
            OwnPages(
                proving=proving,
                sessions=sessions,
                people=self.accounts,
                passwords=passwords,
                factors=factors,
                answers=answers,
                audit=audit,
            ),
            passkey_pages,
            PeoplePages(
                people=self.accounts,
                roster=roster,
                passwords=passwords,
                factors=factors,
                sessions=sessions,
                audit=audit,
            ),
        )
        self.routers = [page.make_router() for page in (*pages, *others)]
        self.tasks = [BackgroundTask(name="check sessions", run=self._check_sessions)]

    def _build_passkeys(
        self, core: Core, sessions: BrowserSessions, factors: SecondFactors, audit: Audit
    ) -> tuple[PasskeyAnswers, PasskeyPages]:
        """Build what asks people's passkeys, and the pages of them."""
        passkeys = Passkeys(core.database, core.clock)
        answers = PasskeyAnswers(
            passkeys=passkeys,
            challenges=PasskeyChallenges(),
            proving=self.proving,
            clock=core.clock,
            audit=audit,
        )
        pages = PasskeyPages(
            answers=answers, passkeys=passkeys, factors=factors, sessions=sessions, audit=audit
        )
        return answers, pages

    def _build_admission(self, core: Core, registry: SiteRegistry) -> SocketAdmission:
        gateways = GatewayAdmission(
            registry=registry,
            resumes=core.resumes,
            # Turns for keys of gateways; people wait in no queue.
            turns=JoinQueue(at_once=JoinQueue.MOST_WAITING),
            shard=core.shard,
            clock=core.clock,
        )
        return SocketAdmission(access=self.access, gateways=gateways, limits=self.limits)

    def _build_displays(self, core: Core, audit: Audit) -> DisplayPages:
        return DisplayPages(
            displays=self.displays,
            access=self.access,
            seats=self.seats,
            sites=core.known_sites,
            audit=audit,
            clock=core.clock,
        )

    def _build_oidc_pages(
        self, core: Core, sessions: BrowserSessions, roster: AccountList, audit: Audit
    ) -> OidcPages:
        return OidcPages(
            signing=self._build_oidc(core, roster, audit),
            access=self.access,
            sessions=sessions,
            identities=Identities(core.database, core.clock),
            roster=roster,
            clock=core.clock,
            audit=audit,
        )

    def _build_oidc(self, core: Core, roster: AccountList, audit: Audit) -> OidcSignIn | None:
        """Build the sign-in by a provider, where the start of the hub names one."""
        if core.settings.oidc is None:
            return None
        return OidcSignIn(
            provider=ProviderClient(read_oidc_settings(core.settings.oidc), core.clock),
            identities=Identities(core.database, core.clock),
            people=self.accounts,
            roster=roster,
            clock=core.clock,
            audit=audit,
        )

    async def open(self) -> None:
        """Remember wrong sign-ins, and offer the set-up page where there is nobody yet."""
        # People sign in at the main shard alone.
        if not self._is_main:
            return
        await self._tries.bring_back()
        self.setup_token = await self.accounts.offer_setup(self._settings.setup_s)

    async def _check_sessions(self) -> None:
        await self.seats.watch(self._settings.check_s)
