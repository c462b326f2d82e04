"""The file that names other servers for histories, and which are shards; read at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import msgspec
from msgspec import Meta

from talaia.hub.errors import CannotStart, StoreError
from talaia.hub.settings_file import read_settings_file
from talaia.hub.sharding.plan import MAIN, ShardPlan
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.history_servers.home_tables import OWN

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence
    from pathlib import Path

__all__ = ["HistoryServersFile", "read_history_servers"]

_MOST_FILE = 256 * 1024
# Each is a lead of its own in every hub, and all of them are written down in one text.
_MOST_SHARDS = 20
_Name = Annotated[str, Meta(pattern=r"^[a-z0-9][a-z0-9-]{0,39}$")]
_Url = Annotated[str, Meta(min_length=1, max_length=1000)]


class HistoryServersFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All of the file.

    Attributes:
        servers: databases by the names that this hub gives them.
        default: which has the history of a new site; ``own`` is the hub's own database. Of
            several, the one that has the fewest sites.
        sites: the same for single sites, by their names.
        shards: those of the servers whose sites have a lead of their own.

    """

    servers: dict[_Name, _Url]
    default: str | tuple[str, ...] = OWN
    sites: dict[str, str] = {}
    shards: tuple[str, ...] = ()

    @property
    def plan(self) -> ShardPlan:
        """Which shards there are."""
        return ShardPlan(self.shards)

    @property
    def defaults(self) -> tuple[str, ...]:
        """Of which one has a new site."""
        return (self.default,) if isinstance(self.default, str) else self.default

    def first_home(
        self, site: str, counts: Mapping[str, int], *, without: Collection[str] = ()
    ) -> str:
        """Give the server of a site that has no history yet.

        Args:
            site: its name.
            counts: how many sites each server has.
            without: servers that may not be it; where no other is named, it is the hub's own
                database.

        """
        named = self.sites.get(site)
        fitting = [name for name in (named, *self.defaults) if name and name not in without]
        if named is not None and fitting[:1] == [named]:
            return named
        # Of those that have as few, the first of the file.
        return min(fitting, key=lambda name: counts.get(name, 0), default=OWN)


def read_history_servers(path: Path) -> HistoryServersFile:
    """Read the file.

    Raises:
        CannotStart: it cannot be read, or names what is not there.

    """
    read = read_settings_file(
        path,
        HistoryServersFile,
        option="--history-servers",
        about="which databases have histories",
        guide="scale",
        most=_MOST_FILE,
    )
    if OWN in read.servers:
        raise CannotStart(
            f"--history-servers {path}: {OWN!r} is the hub's own database",
            "give that server another name",
        )
    for name, url in read.servers.items():
        try:
            parse_database_url(url)
        # The URL is not shown: it may hold a password.
        except StoreError as error:
            raise CannotStart(
                f"--history-servers {path}: {name}: {error.problem}", error.remedy
            ) from error
    if not read.defaults:
        raise CannotStart(
            f"--history-servers {path}: default: names no server", f"leave it out, or name {OWN}"
        )
    for name in (*read.defaults, *read.sites.values()):
        if name != OWN and name not in read.servers:
            raise CannotStart(
                f"--history-servers {path}: there is no server {name!r}",
                f"name one of {', '.join([OWN, *sorted(read.servers)])}",
            )
    _check_shards(path, read.shards, read.servers)
    return read


def _check_shards(path: Path, shards: Sequence[str], servers: Mapping[str, str]) -> None:
    problem = remedy = ""
    unknown = [name for name in shards if name not in servers]
    if OWN in shards:
        problem = f"{OWN!r} cannot be a shard: the hub's own database is the main one's"
        remedy = "leave it out of shards:"
    elif unknown:
        problem = f"shards: there is no server {unknown[0]!r}"
        remedy = f"name some of {', '.join(sorted(servers))}"
    elif len(set(shards)) < len(shards):
        problem, remedy = "shards: one is named twice", "name each once"
    elif len(shards) > _MOST_SHARDS:
        problem = f"shards: there are {len(shards)}"
        remedy = f"name at most {_MOST_SHARDS}"
    elif shards and MAIN in servers:
        problem = f"with shards: no server can be called {MAIN!r}: so is the shard of all others"
        remedy = (
            "give it another name while nothing is stored there, or move its sites"
            " to another server first"
        )
    if problem:
        raise CannotStart(f"--history-servers {path}: {problem}", remedy)
