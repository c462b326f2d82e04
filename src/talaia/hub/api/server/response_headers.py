"""The headers that every answer carries, whatever it says. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["guarding_headers"]

_ALWAYS = (
    # A file is what its type says, and never guessed to be a script.
    ("X-Content-Type-Options", "nosniff"),
    # Our addresses name sites and devices: nobody who is linked to is told.
    ("Referrer-Policy", "no-referrer"),
    # Who opened us has no hold on our window, and nobody loads our files into a page of theirs.
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    # For browsers that do not know frame-ancestors: a click must not land on a hidden button.
    ("X-Frame-Options", "DENY"),
    (
        "Permissions-Policy",
        # Our pages use none of these, and a script that got in should not, either.
        "camera=(), microphone=(), geolocation=(), payment=(), usb=(), serial=(), midi=(),"
        " display-capture=()",
    ),
)
# For a year (s).
_STRICT = ("Strict-Transport-Security", "max-age=31536000")


def guarding_headers(
    host: str, *, tls: bool, pictures: Sequence[str] = ()
) -> list[tuple[str, str]]:
    """Give the headers for an answer to a request of ``host``, which is one of our names or empty.

    Nothing but our own files runs in our pages, no other origin is asked, and nobody frames them.
    ``pictures`` are origins that an admin named: tiles of maps come from there, and nothing else.
    """
    # Older browsers do not count a WebSocket to the same host as 'self'.
    socket = f" {'wss' if tls else 'ws'}://{host}" if host else ""
    tiles = "".join(f" {origin}" for origin in pictures)
    policy = (
        f"default-src 'self'; img-src 'self' blob: data:{tiles}; connect-src 'self'{socket};"
        " worker-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'self';"
        " frame-ancestors 'none'"
    )
    # In the clear browsers do not take it (RFC 6797, 8.1).
    strict = (_STRICT,) if tls else ()
    return [("Content-Security-Policy", policy), *_ALWAYS, *strict]
