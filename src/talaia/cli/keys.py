"""The key file of a site's gateway, as this machine's own hub makes it and keeps it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from talaia.gateway.key_file import KeyPlace, read_key_file
from talaia.hub import accounts

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.gateway.key_file import KeyFile
    from talaia.hub.settings import Settings

__all__ = ["is_good", "make_key"]


async def is_good(settings: Settings, path: Path, site: str) -> bool:
    """Tell whether a file holds a key that this hub still takes for a site.

    Raises:
        SettingsError: there is a file, and it is no key file.
        HubError: the database cannot be opened.

    """
    key = _key_in_file(path)
    # Asked of the hub's database: a file may hold a key that another one has replaced.
    return bool(key) and await accounts.gateway_site(settings, key) == site


def _key_in_file(path: Path) -> str:
    return read_key_file(path).key if path.exists() else ""


async def make_key(settings: Settings, path: Path, content: KeyFile) -> None:
    """Make a key for ``content.site`` and keep it; the one the site had before is void then.

    Raises:
        SettingsError: the file cannot be written, and then no key was made.
        HubError: the database cannot be opened.

    """
    # First: with a folder that cannot be written, the key of before must stay valid.
    place = KeyPlace(path)
    try:
        key = await accounts.create_gateway(settings, content.site)
        place.save_key(replace(content, key=key))
    finally:
        place.close()
