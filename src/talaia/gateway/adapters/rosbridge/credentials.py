"""The token and the certificate authorities of a rosbridge server."""

from __future__ import annotations

import os
import ssl
from typing import TYPE_CHECKING

from talaia.gateway.errors import SettingsError

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.model.connection import RosbridgeConnection

__all__ = ["read_credentials"]


def read_credentials(
    settings: RosbridgeConnection, folder: Path
) -> tuple[dict[str, str], ssl.SSLContext | None]:
    """Read token and authorities. Nothing of them is written anywhere.

    Returns:
        The headers of the connection, and its TLS; none for a server without.

    Raises:
        SettingsError: one of them cannot be read.

    """
    token = ""
    if settings.token_env:
        token = os.environ.get(settings.token_env, "").strip()
        if not token:
            raise SettingsError(f"the variable {settings.token_env} with the token is not set")
    elif settings.token_file:
        path = folder / settings.token_file
        try:
            token = path.read_text().strip()
        except (OSError, UnicodeDecodeError) as error:
            raise SettingsError(f"the token in {path} cannot be read: {error}") from error
    # A line break in it would begin another header.
    if not token.isprintable():
        raise SettingsError("the token of the rosbridge server is not one line of text")
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    if not settings.url.startswith("wss://"):
        return headers, None
    try:
        # Without authorities of its own: those of the machine.
        ca = str(folder / settings.ca) if settings.ca else None
        return headers, ssl.create_default_context(cafile=ca)
    except (OSError, ssl.SSLError) as error:
        raise SettingsError(f"the authorities in {settings.ca} cannot be read: {error}") from error
