"""Gateways as an admin manages them, and the door by which a new one enrols."""

from __future__ import annotations

import io
import shlex
from typing import TYPE_CHECKING, NamedTuple

import segno
from fastapi import APIRouter, Request

from talaia.clock import SECOND
from talaia.hub.api.access import address_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.gateway_schemas import (
    CodeAsk,
    CodeShape,
    EnrolAnswer,
    EnrolAsk,
    GatewayList,
    GatewayShape,
    HeldGatewayShape,
    OpenCodeShape,
    ReconnectAsk,
    SecondGatewayAsk,
)
from talaia.hub.auth.rate_limiter import RateLimiter
from talaia.hub.store.sites.enrolment import EnrolmentRefusal
from talaia.wire.enrolment import EnrolmentCode, pin_of, read_code
from talaia.wire.errors import CodeMistyped

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.ports import Shard
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.enrolment import Enrolment
    from talaia.hub.store.sites.site_registry import KnownGateway, SiteRegistry

__all__ = ["GatewayPages", "Proof"]

_REFUSED = {
    EnrolmentRefusal.UNKNOWN: "this code is not known; compare it with the page, or make a new one"
    " there",
    EnrolmentRefusal.EXPIRED: "this code is too old (a code is good for 15 minutes); make a new"
    " one",
    EnrolmentRefusal.USED: "this code was used already; make a new one for another gateway",
}


class Proof(NamedTuple):
    """How this hub proves itself: SHA-256 of its certificate, as browsers show it, and of its key.

    Both are empty where it speaks plain text, on loopback or behind a proxy.
    """

    fingerprint: str = ""
    key_hash: str = ""


class GatewayPages:
    """The routes of gateways."""

    def __init__(
        self,
        *,
        registry: SiteRegistry,
        enrolment: Enrolment,
        links: OpenLinks,
        audit: Audit,
        clock: Clock,
        proof: Callable[[], Proof],
        shard: Shard,
    ) -> None:
        """Ask ``proof`` for the certificate of now each time: it may have been renewed.

        Gateways are listed whose sites are of ``shard``; codes by the main one.
        """
        self._shard = shard
        self._registry = registry
        self._enrolment = enrolment
        # Connections that are open: a key that became void must not live on in one.
        self._links = links
        self._audit = audit
        self._clock = clock
        self._proof = proof
        # Tries to enrol, by address: a code has far more possibilities than that allows to try.
        self._pace = RateLimiter(burst=10, per_s=0.2)

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/gateways")(self.overview)
        router.post("/api/gateways/codes")(self.offer)
        router.delete("/api/gateways/codes/{code}", status_code=204)(self.withdraw)
        router.post("/api/gateways/{gateway}/revoke", status_code=204)(self.revoke)
        router.post("/api/gateways/{gateway}/reconnect", status_code=202)(self.reconnect)
        router.post("/api/gateways/{gateway}/second", status_code=204)(self.settle)
        router.post("/api/enrol")(self.enrol)
        return router

    async def overview(self) -> GatewayList:
        """List all gateways that have or had a key, and the codes that can still be used."""
        online = self._links.online_gateways()
        known = await self._registry.list_gateways(self._shard.own_rows)
        codes = await self._enrolment.list_open() if self._shard.is_main else []
        return GatewayList(
            gateways=[
                GatewayShape(
                    **{**gateway._asdict(), "id": str(gateway.id)},
                    online=gateway.id in online,
                    held=_held_beside(online.get(gateway.id)),
                )
                for gateway in known
            ],
            codes=[
                OpenCodeShape(
                    id=str(code.id),
                    site=code.site,
                    created_us=code.created_us,
                    expires_us=code.expires_us,
                )
                for code in codes
            ],
        )

    async def offer(self, asked: CodeAsk, request: Request) -> CodeShape:
        """Make a one-time code, good for 15 minutes. It is shown once."""
        made, secret = await self._enrolment.offer_code(asked.site, asked.name)
        proof = self._proof()
        # The code brings a pin of our key along: the gateway knows at once that it speaks to us.
        code = str(EnrolmentCode(secret, pin_of(proof.key_hash) if proof.key_hash else ""))
        command = _enrol_command(request, code, asked.site)
        self._append_record(request, "gateway code made", asked.site, asked.name)
        return CodeShape(
            id=str(made.id),
            code=code,
            expires_us=made.expires_us,
            command=command,
            fingerprint=proof.fingerprint,
            qr=_qr_code(command),
        )

    async def withdraw(self, code: str, request: Request) -> None:
        """Take a code back that was not used."""
        found = await self._enrolment.withdraw_code(_read_number(code))
        if found is None:
            raise ApiProblem(404, "unknown", "there is no such code, or it was used")
        self._append_record(request, "gateway code withdrawn", found.site, found.name)

    async def revoke(self, gateway: str, request: Request) -> None:
        """Make a gateway's key void; its link is closed at once."""
        found = await self._find_gateway(gateway)
        # First the key, then the link: a gateway that dials again at once finds it void.
        if not await self._registry.revoke_key(found.id):
            raise ApiProblem(409, "revoked", "this gateway's key is void already")
        self._links.hang_up(found.id, "its key was revoked")
        self._append_record(request, "gateway revoked", found.site, found.name)

    async def reconnect(self, gateway: str, asked: ReconnectAsk, request: Request) -> None:
        """Let a gateway dial again, or connect anew to one device. An event tells how it went."""
        found = await self._find_gateway(gateway)
        name = who_of(request).name
        if found.id not in self._links.online_gateways():
            raise ApiProblem(409, "offline", "this gateway is not connected now")
        if not asked.device:
            self._append_record(request, "gateway reconnect asked", found.site, found.name)
            self._links.hang_up(found.id, f"{name} asked it to dial again")
        elif not self._links.reconnect_device(found.id, asked.device, name):
            raise ApiProblem(404, "unknown", "this gateway has no such device")
        else:
            self._append_record(
                request, "device reconnect asked", found.site, found.name, device=asked.device
            )

    async def settle(self, gateway: str, asked: SecondGatewayAsk, request: Request) -> None:
        """Decide which one of two gateways with one key stays; the other one waits."""
        found = await self._find_gateway(gateway)
        live = self._links.online_gateways().get(found.id)
        if live is None or not live.rivals.settle_held(replaces=asked.stays == "held"):
            raise ApiProblem(409, "alone", "no second gateway waits now")
        said = "the one that waited takes the place"
        if asked.stays == "linked":
            said = "the one that is linked stays"
        self._append_record(request, "second gateway settled", found.site, said)

    async def enrol(self, asked: EnrolAsk, request: Request) -> EnrolAnswer:
        """Trade a one-time code for a gateway's own key; the site's earlier key is void then."""
        address = address_of(request)
        wait_ns = self._pace.request_turn(address, self._clock.monotonic_ns())
        if wait_ns:
            raise ApiProblem(429, "busy", "too many tries; wait a little", -(-wait_ns // SECOND))
        try:
            # Its own check finds a slip of the hand without a look-up.
            code = read_code(asked.code)
        except CodeMistyped as error:
            self._record_refusal(address, "mistyped")
            raise ApiProblem(422, "mistyped", str(error)) from error
        done = await self._enrolment.redeem_code(code.secret, asked.name)
        if isinstance(done, EnrolmentRefusal):
            self._record_refusal(address, done.value)
            status = 404 if done is EnrolmentRefusal.UNKNOWN else 410
            raise ApiProblem(status, done.value, _REFUSED[done])
        # The former gateway of the site would otherwise go on until the next check of keys.
        for before in done.replaced:
            self._links.hang_up(before, "another gateway has enrolled for this site")
        self._audit.append_record(
            "gateway enrolled", address=address, site=done.site, message=asked.name
        )
        return EnrolAnswer(
            site=done.site,
            gateway=str(done.gateway),
            key=done.key,
            fingerprint=self._proof().fingerprint,
        )

    async def _find_gateway(self, gateway: str) -> KnownGateway:
        found = await self._registry.find_gateway(_read_number(gateway))
        if found is None:
            raise ApiProblem(404, "unknown", "there is no such gateway")
        return found

    def _append_record(
        self, request: Request, kind: str, site: str, message: str, *, device: str = ""
    ) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.append_record(
            kind, who=name, address=address, site=site, device=device, message=message
        )

    def _record_refusal(self, address: str, why: str) -> None:
        self._audit.append_record("gateway enrol refused", address=address, message=why, good=False)


def _held_beside(live: LiveSite | None) -> list[HeldGatewayShape]:
    held = [] if live is None else live.rivals.held
    return [
        HeldGatewayShape(address=one.address, version=one.version[:200], since_us=one.since_us)
        for one in held
    ]


def _read_number(text: str) -> int:
    """Read an id of a path; what is no number is nobody's."""
    # No row has the number 0.
    return int(text) if text.isascii() and text.isdecimal() and len(text) < 19 else 0


def _enrol_command(request: Request, code: str, site: str) -> str:
    """Write what to run beside the robot; the Host header was held against the list of ours."""
    hub = f"{request.url.scheme}://{request.headers['host']}"
    plain = ["--allow-plain"] if request.url.scheme == "http" else []
    words = ["talaia", "gateway", "enrol", hub, code, "--key-file", f"{site}.key", *plain]
    # It is pasted into a shell.
    return shlex.join(words)


def _qr_code(text: str) -> str:
    out = io.BytesIO()
    segno.make(text, error="m", micro=False).save(
        out, kind="svg", border=2, xmldecl=False, svgns=True, omitsize=True
    )
    return out.getvalue().decode()
