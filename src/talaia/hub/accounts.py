"""Accounts and keys on a hub's data folder, made from outside; the hub may run or not."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.hub.auth.passwords import Passwords, check_name, check_password
from talaia.hub.auth.secret_box import SEAL_FILE, seal_of
from talaia.hub.errors import CannotStart, UnknownPerson
from talaia.hub.store.accounts.mfa import SecondFactors
from talaia.hub.store.accounts.people import People
from talaia.hub.store.accounts.sessions import Sessions
from talaia.hub.store.audit import Audit
from talaia.hub.store.database import open_migrated
from talaia.hub.store.sites.site_registry import SiteRegistry

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from talaia.hub.settings import Settings
    from talaia.hub.store.audit import Chain
    from talaia.hub.store.database import Database

__all__ = [
    "append_audit_record",
    "create_gateway",
    "create_user",
    "gateway_site",
    "make_data_folder",
    "remove_factor",
    "set_password",
    "verify_audit",
]

# Who is named in the audit log; a person of this name would have done it by the pages.
_WHO = "(command line)"


async def create_user(settings: Settings, name: str, password: str, role: str) -> None:
    """Add a person.

    Raises:
        HubError: the name is taken or cannot be used, the password is weak, there is no such
            role, or the database cannot be opened.

    """
    check_name(name)
    check_password(password, name)
    # Before the database is opened: bcrypt takes a while, and needs none.
    hashed = await Passwords(settings.password_cost).hash_password(password)
    async with _open_database(settings) as database:
        await People(database, SystemClock()).add_person(name, hashed, role)
        await append_audit_record(database, "person added", f"{name} ({role})")


async def set_password(settings: Settings, name: str, password: str) -> None:
    """Give a person another password; every session of theirs ends.

    Raises:
        HubError: there is nobody of that name, the password is weak, or the database cannot be
            opened.

    """
    check_password(password, name)
    hashed = await Passwords(settings.password_cost).hash_password(password)
    async with _open_database(settings) as database:
        await People(database, SystemClock()).set_password(name, hashed)
        await append_audit_record(database, "person changed", f"{name}: new password")


async def remove_factor(settings: Settings, name: str) -> bool:
    """Take a person's second factor away, for one who has lost it; their sessions end.

    Returns:
        False when there was none.

    Raises:
        HubError: there is nobody of that name, or the database cannot be opened.

    """
    async with _open_database(settings) as database:
        person = await People(database, SystemClock()).find_by_name(name)
        if person is None:
            raise UnknownPerson(f"there is no person named {name!r}")
        key = settings.data / SEAL_FILE
        removed = await SecondFactors(database, SystemClock(), lambda: seal_of(key)).remove_factor(
            person.id
        )
        # Whoever had the lost device may be signed in somewhere.
        await Sessions(database, SystemClock(), settings).end_all(person.id)
        await append_audit_record(database, "person's second factor removed", name)
    return removed


async def create_gateway(settings: Settings, site: str) -> str:
    """Make a key for the gateway of a site; the one it had before is void from now on.

    Raises:
        HubError: the database cannot be opened.

    """
    async with _open_database(settings) as database:
        key = await SiteRegistry(database, SystemClock()).new_key(site)
        await append_audit_record(database, "gateway key made", "", site)
    return key


async def gateway_site(settings: Settings, key: str) -> str | None:
    """Tell which site a gateway's key is for; none when it is void or unknown.

    Raises:
        HubError: the database cannot be opened.

    """
    async with _open_database(settings) as database:
        found = await SiteRegistry(database, SystemClock()).gateway_of(key)
    return None if found is None else found.site


async def verify_audit(settings: Settings, heads: Mapping[int, str]) -> Chain:
    """Hold the audit log against its chain, and against what signed heads say of rows.

    Raises:
        HubError: the database cannot be opened.

    """
    async with _open_database(settings) as database:
        return await Audit(database, SystemClock()).verify_chain(heads)


def make_data_folder(settings: Settings) -> None:
    """Make the data folder, readable by its owner only.

    Raises:
        CannotStart: it cannot be made.

    """
    try:
        settings.data.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise CannotStart(
            f"the data folder {settings.data} cannot be made: {error.strerror}",
            "choose another with --data",
        ) from error


async def append_audit_record(database: Database, kind: str, message: str, site: str = "") -> None:
    """Write down what was done past the pages; whoever may do it has the data folder or the URL."""
    audit = Audit(database, SystemClock())
    audit.append_record(kind, who=_WHO, message=message, site=site)
    # Told to stop first: then `run` writes what waits, once, and returns.
    audit.stop()
    await audit.run()


@asynccontextmanager
async def _open_database(settings: Settings) -> AsyncIterator[Database]:
    # A command may be the first thing ever run on this folder.
    make_data_folder(settings)
    async with open_migrated(settings.url) as database:
        yield database
