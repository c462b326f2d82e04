"""The file that names other servers for histories: read once, at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import msgspec
from msgspec import Meta

from talaia.hub.errors import CannotStart, StoreError
from talaia.hub.settings_file import read_settings_file
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.history_servers.home_tables import OWN

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["HistoryServersFile", "read_history_servers"]

_MOST_FILE = 256 * 1024
_Name = Annotated[str, Meta(pattern=r"^[a-z0-9][a-z0-9-]{0,39}$")]
_Url = Annotated[str, Meta(min_length=1, max_length=1000)]


class HistoryServersFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All of the file.

    Attributes:
        servers: databases by the names that this hub gives them.
        default: which has the history of a new site; ``own`` is the hub's own database.
        sites: the same for single sites, by their names.

    """

    servers: dict[_Name, _Url]
    default: str = OWN
    sites: dict[str, str] = {}

    def first_home(self, site: str) -> str:
        """Give the server of a site that has no history yet."""
        return self.sites.get(site, self.default)


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
    for name in (read.default, *read.sites.values()):
        if name != OWN and name not in read.servers:
            raise CannotStart(
                f"--history-servers {path}: there is no server {name!r}",
                f"name one of {', '.join([OWN, *sorted(read.servers)])}",
            )
    return read
