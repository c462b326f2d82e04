"""Addresses of servers in a description: a scheme, a host, and never a password."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.model.checks.identifiers import Finding

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["url_fits"]


def url_fits(
    where: str,
    url: str,
    schemes: tuple[str, ...],
    *,
    example: str,
    instead: str = "use token_file or token_env",
) -> Iterator[Finding]:
    """List what is wrong with an address.

    Args:
        where: its place.
        url: the address.
        schemes: that it may have.
        example: a host that shows how it is written.
        instead: where the password goes that stands in it.

    """
    remedy = f"write it as {schemes[0]}://{example}"
    try:
        parts = urlsplit(url)
        # To read ``port`` raises `ValueError` where that is no number of a port.
        fits = parts.scheme in schemes and bool(parts.hostname) and parts.port != 0
    except ValueError:
        yield Finding(where, "it is not an address", remedy)
        return
    if not fits:
        yield Finding(where, f"expected {' or '.join(schemes)}://host:port", remedy)
    # Descriptions are shown, copied and kept: no password belongs into one.
    elif parts.username or parts.password:
        yield Finding(where, "there is a password in it", instead)
