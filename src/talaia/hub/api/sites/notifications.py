"""Ways that admins set up, rules that people choose, and a test that shows the real error.

Long, because the routes of channels, rules and browsers share their checks.
"""

from __future__ import annotations

import base64
import json
import re
from typing import TYPE_CHECKING, Literal

import msgspec
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
from fastapi import APIRouter, Request

from talaia.extensions.installed import installed_extensions
from talaia.hub.alarms.rules import Rule
from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.notification_schemas import (
    NoticeRuleShape,
    PushAsk,
    PushBrowserShape,
    PushList,
    RuleAsk,
    RuleList,
    WayAsk,
    WayChoice,
    WayChoiceList,
    WayList,
    WayShape,
    WentShape,
)
from talaia.hub.auth.tokens import new_token
from talaia.hub.errors import NameTaken
from talaia.hub.notify.message import compose_test_message
from talaia.hub.notify.senders import Outcome
from talaia.hub.store.alarms.notification_channels import WayKind
from talaia.model.alarms.alarm import Severity

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.notify.delivery_worker import Sends
    from talaia.hub.store.alarms.notification_channels import NotifyStore, Way
    from talaia.hub.store.audit import Audit

__all__ = ["NotifyPages"]

# One plain address: nothing that a header or a list of receivers could be made of.
_MAIL = re.compile(r"[^\s<>(),:;\"\\@]{1,64}@[A-Za-z0-9.\-]{1,135}\Z")
# Settings of mail that are no secrets; they are shown to admins again.
_PLAIN = ("host", "port", "security", "sender", "user")


class NotifyPages:
    """The routes of ways, rules and browsers."""

    def __init__(self, store: NotifyStore, sender: Sends, audit: Audit, clock: Clock) -> None:
        """Keep them in ``store``; tests go out by ``sender``."""
        self._store = store
        self._sender = sender
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/ways")(self.ways)
        router.post("/api/ways", status_code=201)(self.add_way)
        router.put("/api/ways/{way}", status_code=204)(self.change_way)
        router.delete("/api/ways/{way}", status_code=204)(self.remove_way)
        router.post("/api/ways/{way}/test")(self.test_way)
        router.get("/api/me/ways")(self.choices)
        router.get("/api/me/rules")(self.rules)
        router.post("/api/me/rules", status_code=201)(self.add_rule)
        router.put("/api/me/rules/{rule}", status_code=204)(self.change_rule)
        router.delete("/api/me/rules/{rule}", status_code=204)(self.remove_rule)
        router.post("/api/me/rules/{rule}/test")(self.test_rule)
        router.get("/api/me/push")(self.push)
        router.post("/api/me/push", status_code=204)(self.add_browser)
        router.delete("/api/me/push/{browser}", status_code=204)(self.remove_browser)
        return router

    async def ways(self) -> WayList:
        """List the ways; of their secrets only that they are set."""
        return WayList(ways=[_way_shape(way) for way in await self._store.list_ways()])

    async def add_way(self, asked: WayAsk, request: Request) -> WayChoice:
        """Set a way up."""
        number = await self._save_channel(None, asked)
        self._append_record(request, "way of alarms added", f"{asked.name} ({asked.kind})")
        return WayChoice(id=str(number), name=asked.name, kind=asked.kind)

    async def change_way(self, way: str, asked: WayAsk, request: Request) -> None:
        """Change a way. Secrets stay as they are unless given, or the server is another."""
        number = number_of(way, "way")
        if await self._save_channel(number, asked) is None:
            raise ApiProblem(404, "unknown", "there is no such way of this kind")
        self._append_record(request, "way of alarms changed", f"{asked.name} ({asked.kind})")

    async def remove_way(self, way: str, request: Request) -> None:
        """Remove a way, and every rule that uses it."""
        if not await self._store.remove_way(number_of(way, "way")):
            raise ApiProblem(404, "unknown", "there is no such way")
        self._append_record(request, "way of alarms removed", way)

    async def test_way(self, way: str, request: Request) -> WentShape:
        """Send a test by a way: to its own sender, or to your browsers."""
        found = await self._store.find_way(number_of(way, "way"))
        if found is None:
            raise ApiProblem(404, "unknown", "there is no such way")
        # To nobody of the tester's choice: else it would be a way to send mail to anyone.
        return await self._send_test(request, *found, found[0].settings.get("sender", ""))

    async def choices(self) -> WayChoiceList:
        """List the ways that you can be told by."""
        return WayChoiceList(
            ways=[
                WayChoice(id=str(way.id), name=way.name, kind=way.kind)
                for way in await self._store.list_ways()
            ]
        )

    async def rules(self, request: Request) -> RuleList:
        """List your rules."""
        found = await self._store.rules_of(who_of(request).user)
        return RuleList(rules=[_rule_shape(rule) for rule in found])

    async def add_rule(self, asked: RuleAsk, request: Request) -> NoticeRuleShape:
        """Be told of alarms, of those that you may view."""
        way, rule = await self._make_rule(0, asked, request)
        number = await self._store.add_rule(rule)
        if number is None:
            raise ApiProblem(409, "too_many", "you have as many rules as one person may have")
        self._append_record(request, "rule of alarms added", f"{way.name} {asked.site}")
        return NoticeRuleShape(id=str(number), **asked.model_dump())

    async def change_rule(self, rule: str, asked: RuleAsk, request: Request) -> None:
        """Change one of your rules. What waits to be told by it goes where it says from now on."""
        way, wanted = await self._make_rule(number_of(rule, "rule"), asked, request)
        if not await self._store.change_rule(wanted):
            raise ApiProblem(404, "unknown", "you have no such rule")
        self._append_record(request, "rule of alarms changed", f"{way.name} {asked.site}")

    async def remove_rule(self, rule: str, request: Request) -> None:
        """Be told by this rule no more."""
        if not await self._store.remove_rule(who_of(request).user, number_of(rule, "rule")):
            raise ApiProblem(404, "unknown", "you have no such rule")
        self._append_record(request, "rule of alarms removed", rule)

    async def test_rule(self, rule: str, request: Request) -> WentShape:
        """Send a test by one of your rules."""
        number = number_of(rule, "rule")
        mine = await self._store.rules_of(who_of(request).user)
        # Among one's own: another's rule is as if it were not there.
        wanted = next((channel for channel in mine if channel.id == number), None)
        found = await self._store.find_way(wanted.way) if wanted else None
        if wanted is None or found is None:
            raise ApiProblem(404, "unknown", "you have no such rule")
        if not who_of(request).grants.permissions:
            # Nor is there any alarm to be told of: the hub sends no mail for passers-by.
            raise ApiProblem(403, "forbidden", "there are no alarms that you may view")
        return await self._send_test(request, *found, wanted.target)

    async def push(self, request: Request) -> PushList:
        """List your browsers that take messages, and the key by which another can."""
        ways = [way for way in await self._store.list_ways() if way.kind is WayKind.PUSH]
        return PushList(
            # There is one at most; see `_push_keys`.
            key=ways[0].settings["public_key"] if ways else "",
            browsers=[
                PushBrowserShape(
                    id=str(browser.id), agent=browser.agent, created_us=browser.created_us
                )
                for browser in await self._store.browsers_of(who_of(request).user)
            ],
        )

    async def add_browser(self, asked: PushAsk, request: Request) -> None:
        """Let this browser take messages."""
        # Only shown, so that the person knows which browser it is.
        agent = request.headers.get("user-agent", "")[:200]
        printable = "".join(letter if letter.isprintable() else "?" for letter in agent)
        number = await self._store.add_browser(
            who_of(request).user, asked.model_dump(), printable, self._now_us()
        )
        if number is None:
            raise ApiProblem(409, "too_many", "you have as many browsers as one person may have")

    async def remove_browser(self, browser: str, request: Request) -> None:
        """Let a browser take no more messages."""
        if not await self._store.remove_browser(
            who_of(request).user, number_of(browser, "browser")
        ):
            raise ApiProblem(404, "unknown", "you have no such browser")

    async def _make_rule(self, number: int, asked: RuleAsk, request: Request) -> tuple[Way, Rule]:
        """Give what was asked for as a rule of that number, and the way it tells by."""
        found = await self._store.find_way(int(asked.way))
        if found is None:
            raise ApiProblem(422, "invalid", "there is no such way")
        if found[0].kind is WayKind.MAIL and not _MAIL.match(asked.target):
            raise ApiProblem(422, "invalid", "target: expected one mail address")
        return found[0], Rule(
            id=number,
            user=who_of(request).user,
            site=asked.site,
            way=int(asked.way),
            target=asked.target,
            least=Severity(asked.least),
            over=asked.over,
            quiet_from=asked.quiet_from,
            quiet_to=asked.quiet_to,
            quiet_least=Severity(asked.quiet_least),
            zone=asked.zone,
            group_s=asked.group_s,
            own_requests=asked.own_requests,
            nights=asked.nights,
        )

    async def _save_channel(self, number: int | None, asked: WayAsk) -> int | None:
        secrets = {
            key: said
            for key, said in asked.secrets.model_dump(exclude={"keys"}).items()
            if said is not None
        }
        settings: dict[str, str] = {}
        if asked.kind == "mail":
            settings = {key: str(getattr(asked, key)) for key in _PLAIN}
            # Only what this kind uses is kept, whatever was sent.
            secrets = {key: said for key, said in secrets.items() if key == "password"}
        elif asked.kind == "extension":
            settings = {"extension": asked.extension}
            secrets = _extension_keys(asked, new=number is None)
        elif asked.kind == "push":
            settings, secrets = await self._push_keys(number)
            settings.update(sender=asked.sender, subject=f"mailto:{asked.sender}")
        else:
            wanted = {"url", "token"} if asked.kind == "webhook" else {"url"}
            secrets = {key: said for key, said in secrets.items() if key in wanted}
            if number is None and not secrets.get("url"):
                raise ApiProblem(422, "invalid", "url: expected the address")
        try:
            return await self._store.put_way(
                number,
                asked.name,
                kind=asked.kind,
                settings=settings,
                secrets=secrets,
                now_us=self._now_us(),
            )
        except NameTaken as error:
            raise ApiProblem(409, "taken", "there is a way of that name already") from error

    async def _push_keys(self, number: int | None) -> tuple[dict[str, str], dict[str, str]]:
        """Give the key pair of Web Push (VAPID, RFC 8292), made when it is set up."""
        if number is not None:
            found = await self._store.find_way(number)
            if found is not None and found[0].kind is WayKind.PUSH:
                return {"public_key": found[0].settings["public_key"]}, dict(found[1])
        # Subscriptions are bound to the key that they were made with (RFC 8292, 4).
        if any(way.kind is WayKind.PUSH for way in await self._store.list_ways()):
            raise ApiProblem(409, "taken", "Web Push is set up already")
        key = ec.generate_private_key(ec.SECP256R1())
        private = key.private_numbers().private_value.to_bytes(32, "big")
        # The form that a browser's Push API takes.
        public = key.public_key().public_bytes(Encoding.X962, PublicFormat.UncompressedPoint)
        return {"public_key": _encode_base64(public)}, {"private_key": _encode_base64(private)}

    async def _send_test(
        self, request: Request, way: Way, secrets: dict[str, str], target: str
    ) -> WentShape:
        who = who_of(request)
        browsers = await self._store.browsers_of(who.user) if way.kind is WayKind.PUSH else []
        # A key of its own, so that no receiver takes it for a message it had before.
        message = compose_test_message(new_token()[:32], who.name)
        went = await self._sender.send_message(
            way, secrets, target=target, message=message, browsers=browsers
        )
        for number in went.gone:
            await self._store.remove_browser(who.user, number)
        self._append_record(request, "way of alarms tested", f"{way.name}: {went.outcome}")
        problem = went.problem or ("" if went.outcome is Outcome.SENT else "it was not sent")
        return WentShape(sent=went.outcome is Outcome.SENT, problem=problem)

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.append_record(kind, who=name, address=address, message=message)

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _encode_base64(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).decode().rstrip("=")


def _extension_keys(asked: WayAsk, *, new: bool) -> dict[str, str]:
    """Give the keys of a notifier as the one secret that they are kept as."""
    known = installed_extensions().notifiers_by_name().get(asked.extension)
    if known is None:
        there = ", ".join(sorted(installed_extensions().notifiers_by_name())) or "none"
        raise ApiProblem(
            422, "invalid", f"extension: it is not installed at this hub; installed: {there}"
        )
    given = asked.secrets.keys
    if given is None and not new:
        return {}
    keys = {key: said for key, said in (given or {}).items() if said}
    try:
        msgspec.convert(keys, known.keys, strict=False)
    except msgspec.ValidationError as error:
        raise ApiProblem(422, "invalid", f"keys: {error}") from error
    # Even none at all are kept, in place of those of before.
    return {"keys": json.dumps(keys)}


def _way_shape(way: Way) -> WayShape:
    settings = way.settings
    return WayShape(
        id=str(way.id),
        name=way.name,
        kind=way.kind,
        extension=settings.get("extension", ""),
        host=settings.get("host", ""),
        port=int(settings.get("port", "587")),
        security=_read_security(settings.get("security", "")),
        sender=settings.get("sender", ""),
        user=settings.get("user", ""),
        secrets=list(way.secrets),
    )


def _read_security(word: str) -> Literal["starttls", "tls", "none"]:
    if word == "tls":
        return "tls"
    return "none" if word == "none" else "starttls"


def _rule_shape(rule: Rule) -> NoticeRuleShape:
    return NoticeRuleShape(
        id=str(rule.id),
        site=rule.site,
        way=str(rule.way),
        target=rule.target,
        least=rule.least,
        over=rule.over,
        quiet_from=rule.quiet_from,
        quiet_to=rule.quiet_to,
        quiet_least=rule.quiet_least,
        zone=rule.zone,
        group_s=rule.group_s,
        own_requests=rule.own_requests,
        nights=rule.nights,
    )
