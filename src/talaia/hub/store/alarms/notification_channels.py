"""Ways by which people are told, their rules, and the browsers that take Web Push.

Long, because channels, rules and browsers are bound to each other by one set of statements.
"""

from __future__ import annotations

import hashlib
import json
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.exc import IntegrityError

from talaia.hub.errors import NameTaken
from talaia.hub.store.alarm_tables import notify_rules, notify_ways, push_browsers
from talaia.hub.store.alarms.notification_outbox import rule_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.hub.alarms.rules import Rule
    from talaia.hub.auth.secret_box import Seal
    from talaia.hub.store.database import Database

__all__ = ["MOST_BROWSERS", "MOST_RULES", "NotifyStore", "PushBrowser", "Way", "WayKind"]

# What says where a message goes.
_SERVER = ("host", "port", "security", "extension")
# Of one person.
MOST_RULES = 50
MOST_BROWSERS = 20


class WayKind(StrEnum):
    """How a message goes out."""

    MAIL = "mail"
    WEBHOOK = "webhook"
    # ntfy, Matrix, Telegram.
    CHAT = "chat"
    PUSH = "push"
    # An installed extension sends it.
    EXTENSION = "extension"


class Way(NamedTuple):
    """A server that messages go to, as an admin has set it up.

    Attributes:
        settings: what may be read again.
        secrets: names of those that are kept sealed; never what they are.

    """

    id: int
    name: str
    kind: WayKind
    settings: Mapping[str, str]
    secrets: tuple[str, ...]


class PushBrowser(NamedTuple):
    """A browser that takes messages of one person."""

    id: int
    agent: str
    created_us: int
    subscription: Mapping[str, str]


class NotifyStore:
    """Rows of ways, rules and browsers."""

    def __init__(self, database: Database, seal: Callable[[], Seal]) -> None:
        """Work on ``database``; secrets are kept under the seal that ``seal`` gives."""
        self._database = database
        # Passwords of mail servers and the like are sealed in the database.
        self._seal = seal

    async def list_ways(self) -> list[Way]:
        """List the ways, by name."""
        async with self._database.read() as connection:
            rows = await connection.execute(select(notify_ways).order_by(notify_ways.c.name))
            return [self._row_to_way(row) for row in rows]

    async def find_way(self, number: int) -> tuple[Way, dict[str, str]] | None:
        """Give a way with its secrets, for whoever delivers."""
        async with self._database.read() as connection:
            rows = await connection.execute(select(notify_ways).where(notify_ways.c.id == number))
            row = rows.first()
        return None if row is None else (self._row_to_way(row), self._open_secrets(row))

    async def put_way(
        self,
        number: int | None,
        name: str,
        *,
        kind: WayKind,
        settings: Mapping[str, str],
        secrets: Mapping[str, str],
        now_us: int,
    ) -> int | None:
        """Add a way, or change one; give its number, or None when there is none to change.

        A changed way keeps the secrets that ``secrets`` does not name: they cannot be read, so
        nobody can send them along. One that is given as an empty text is removed.

        Raises:
            NameTaken: there is one of that name.

        """
        try:
            async with self._database.write() as connection:
                before: dict[str, str] = {}
                if number is not None:
                    rows = await connection.execute(
                        select(notify_ways).where(notify_ways.c.id == number)
                    )
                    row = rows.first()
                    if row is None or row.kind != kind.value:
                        return None
                    before = (
                        {} if _is_other_server(row, settings, secrets) else self._open_secrets(row)
                    )
                kept = {key: said for key, said in {**before, **secrets}.items() if said}
                values = {
                    "name": name,
                    "kind": kind.value,
                    "settings": json.dumps(dict(settings)),
                    "changed_us": now_us,
                }
                if number is None:
                    added = await connection.execute(
                        insert(notify_ways).values(**values, sealed="")
                    )
                    key = added.inserted_primary_key
                    number = int(key[0]) if key else 0
                    values = {}
                # Sealed for its number, which a new one has only now.
                sealed = (
                    self._seal().seal_text(json.dumps(kept), _about_way(number)) if kept else ""
                )
                await connection.execute(
                    update(notify_ways)
                    .where(notify_ways.c.id == number)
                    .values(**values, sealed=sealed)
                )
        except IntegrityError as error:
            raise NameTaken(name) from error
        return number

    async def remove_way(self, number: int) -> bool:
        """Remove a way, and every rule that uses it."""
        async with self._database.write() as connection:
            done = await connection.execute(delete(notify_ways).where(notify_ways.c.id == number))
        return done.rowcount == 1

    async def rules_of(self, user: int) -> list[Rule]:
        """List a person's rules."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(notify_rules)
                .where(notify_rules.c.user_id == user)
                .order_by(notify_rules.c.id)
            )
            return [rule_of(row) for row in rows]

    async def add_rule(self, rule: Rule) -> int | None:
        """Add a rule; None when the person has too many."""
        async with self._database.write() as connection:
            mine = select(func.count()).where(notify_rules.c.user_id == rule.user)
            if int((await connection.execute(mine)).scalar_one()) >= MOST_RULES:
                return None
            added = await connection.execute(insert(notify_rules).values(_row_of(rule)))
            key = added.inserted_primary_key
        return int(key[0]) if key else 0

    async def change_rule(self, rule: Rule) -> bool:
        """Change one of a person's rules; it keeps its number.

        What waits in the outbox by it is told all the same, at the time that it was to be told:
        whoever delivers asks the rule where to (`NotificationOutbox.claim_due`).
        """
        async with self._database.write() as connection:
            done = await connection.execute(
                update(notify_rules)
                .where(notify_rules.c.id == rule.id, notify_rules.c.user_id == rule.user)
                .values(_row_of(rule))
            )
        return done.rowcount == 1

    async def remove_rule(self, user: int, number: int) -> bool:
        """Remove one of a person's rules."""
        async with self._database.write() as connection:
            done = await connection.execute(
                delete(notify_rules).where(
                    notify_rules.c.id == number, notify_rules.c.user_id == user
                )
            )
        return done.rowcount == 1

    async def browsers_of(self, user: int) -> list[PushBrowser]:
        """List the browsers of a person that take messages."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(push_browsers)
                .where(push_browsers.c.user_id == user)
                .order_by(push_browsers.c.id)
            )
            found = rows.all()
        opened = [(row, self._seal().open_text(row.sealed, row.endpoint_hash)) for row in found]
        return [
            PushBrowser(row.id, row.agent, row.created_us, json.loads(text))
            for row, text in opened
            if text is not None
        ]

    async def add_browser(
        self, user: int, subscription: Mapping[str, str], agent: str, now_us: int
    ) -> int | None:
        """Let a browser take messages of a person, of nobody else from now on."""
        hashed = hashlib.sha256(subscription["endpoint"].encode()).hexdigest()
        async with self._database.write() as connection:
            # A browser is of one person: whoever subscribes it last.
            await connection.execute(
                delete(push_browsers).where(push_browsers.c.endpoint_hash == hashed)
            )
            mine = select(func.count()).where(push_browsers.c.user_id == user)
            if int((await connection.execute(mine)).scalar_one()) >= MOST_BROWSERS:
                return None
            added = await connection.execute(
                insert(push_browsers).values(
                    user_id=user,
                    endpoint_hash=hashed,
                    sealed=self._seal().seal_text(json.dumps(dict(subscription)), hashed),
                    agent=agent,
                    created_us=now_us,
                )
            )
            key = added.inserted_primary_key
        return int(key[0]) if key else 0

    async def remove_browser(self, user: int, number: int) -> bool:
        """Let a browser of a person take no more messages."""
        async with self._database.write() as connection:
            done = await connection.execute(
                delete(push_browsers).where(
                    push_browsers.c.id == number, push_browsers.c.user_id == user
                )
            )
        return done.rowcount == 1

    def _row_to_way(self, row: object) -> Way:
        found = row._mapping  # type: ignore[attr-defined]  # noqa: SLF001 - SQLAlchemy's own name
        return Way(
            found["id"],
            found["name"],
            WayKind(found["kind"]),
            json.loads(found["settings"]),
            tuple(sorted(self._open_secrets(row))),
        )

    def _open_secrets(self, row: object) -> dict[str, str]:
        found = row._mapping  # type: ignore[attr-defined]  # noqa: SLF001 - SQLAlchemy's own name
        text = (
            self._seal().open_text(found["sealed"], _about_way(found["id"]))
            if found["sealed"]
            else ""
        )
        opened: dict[str, str] = json.loads(text) if text else {}
        return opened


def _row_of(rule: Rule) -> dict[str, object]:
    return {
        "user_id": rule.user,
        "site": rule.site,
        "way": rule.way,
        "target": rule.target,
        "least": rule.least.value,
        "over": rule.over,
        "quiet_from": rule.quiet_from,
        "quiet_to": rule.quiet_to,
        "quiet_least": rule.quiet_least.value,
        "zone": rule.zone,
        "group_s": rule.group_s,
        "own_requests": rule.own_requests,
        "nights": rule.nights,
    }


def _about_way(number: int) -> str:
    return f"way {number}"


def _is_other_server(row: object, settings: Mapping[str, str], secrets: Mapping[str, str]) -> bool:
    """Tell whether it goes to another server than before.

    There a kept secret is of no use: else whoever may change a way could have it sent to a server
    of theirs.
    """
    before = json.loads(row.settings)  # type: ignore[attr-defined]
    moved = any(before.get(key) != settings.get(key) for key in _SERVER)
    return moved or "url" in secrets
