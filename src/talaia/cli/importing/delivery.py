"""Parcels on their way into the history: to the hub that runs, or past it when none does."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError
from talaia.clock import SystemClock
from talaia.hub.accounts import append_audit_record
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.servers.build_history import build_history, check_homes
from talaia.hub.live.files.import_inbox import BAD, ImportInbox, ImportResult, answer_of
from talaia.hub.lock import HubRuns, hub_lock
from talaia.hub.store.database import Database, open_migrated
from talaia.hub.store.sites.site_registry import SiteRegistry

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from talaia.hub.history.import_file import Head
    from talaia.hub.settings import Settings

__all__ = ["deliver_parcels", "known_description"]

_LOOK_S = 0.2


def deliver_parcels(
    settings: Settings, paths: Sequence[Path], say: Callable[[str], None]
) -> list[ImportResult]:
    """Wait until parcels are in the history, or bring them there when no hub runs.

    Raises:
        CliError: the hub set one aside, for it could not read it.
        HubError: the database cannot be opened, or does not take them; they stay where they are.

    """
    # Once for a wait that may take minutes.
    told = False
    while True:
        try:
            # Tried each time: a hub that ends while we wait leaves the rest of the work to us.
            with hub_lock(settings.data):
                return asyncio.run(_deliver_files(settings, paths))
        # The parcels stay: they are complete, and the next hub takes them by itself.
        except HistoryError as error:
            raise CliError(
                f"{error}; what is to be imported waits in {paths[0].parent}, and the hub takes it"
                " over when it is started"
            ) from error
        except HubRuns:
            if not told:
                say("the hub is running and imports it")
            told = True
        # Asked only while another has the lock: without a hub nobody answers.
        taken = _fetch_results(paths)
        if taken is not None:
            return taken
        time.sleep(_LOOK_S)


def known_description(settings: Settings, site: str) -> str | None:
    """Give the description by which the hub knows a site.

    Raises:
        HubError: the database cannot be opened.

    """

    async def read_known_site() -> str | None:
        async with open_migrated(settings.url) as database:
            known = await SiteRegistry(database, SystemClock()).list_sites()
        return next(
            (known_site.description for known_site in known if known_site.site == site), None
        )

    return asyncio.run(read_known_site())


def _fetch_results(paths: Sequence[Path]) -> list[ImportResult] | None:
    """Give the hub's answers, once there is one to each parcel."""
    # All or none: an answer is removed when it is read, and would be lost with a partial list.
    if any(path.exists() for path in paths):
        return None
    if aside := [path for path in paths if path.with_suffix(BAD).exists()]:
        raise CliError(
            f"the hub could not read {aside[0].with_suffix(BAD)} and set it aside; its log says "
            "why. Import the file again"
        )
    return [answer_of(path) or ImportResult(0, 0) for path in paths]


async def _deliver_files(settings: Settings, paths: Sequence[Path]) -> list[ImportResult]:
    clock = SystemClock()
    database = Database(settings.url)
    # Neither rows to show nor tidying: this writer lives for one import, and a hub follows.
    history = build_history(settings, database, clock, HistoryLimits(show_s=0, tidy_s=0))
    registry = SiteRegistry(database, clock)

    async def taken(head: Head, how: ImportResult) -> None:
        # A site that no gateway has ever brought still needs its row, or nobody could open its
        # history.
        if head.site not in {known_site.site for known_site in await registry.list_sites()}:
            await registry.said_hello(head.site, head.description, "", "")
        message = f"{head.file}: {how.stored} samples, {how.there} were there already"
        # Written here for no hub does it: an import without one must not be missing from the
        # record.
        await append_audit_record(database, "history imported", message, head.site)

    answers = []
    try:
        # The hub may never have run with this version; the schema must fit before anything is
        # written.
        await database.migrate()
        if not settings.history_servers:
            await check_homes(database)
        await history.open()
        try:
            inbox = ImportInbox(history, settings.data, taken)
            for path in paths:
                # A hub that ended meanwhile may have taken some of them.
                if path.exists():
                    await inbox.import_file(path)
                answers.append(answer_of(path) or ImportResult(0, 0))
        finally:
            await history.close()
    finally:
        await database.close()
    return answers
