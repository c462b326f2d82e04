"""The headers that every answer carries, whatever it says. Pure."""

from __future__ import annotations

__all__ = ["guarding_headers"]

_ALWAYS = (
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("X-Frame-Options", "DENY"),
    (
        "Permissions-Policy",
        "camera=(), microphone=(), geolocation=(), payment=(), usb=(), serial=(), midi=(),"
        " display-capture=()",
    ),
)
_STRICT = ("Strict-Transport-Security", "max-age=31536000")


def guarding_headers(host: str, *, tls: bool) -> list[tuple[str, str]]:
    """Give the headers for an answer to a request of ``host``, which is one of our names or empty.

    Nothing but our own files runs in our pages, no other origin is asked, and nobody frames them.
    """
    # Older browsers do not count a WebSocket to the same host as 'self'.
    socket = f" {'wss' if tls else 'ws'}://{host}" if host else ""
    policy = (
        f"default-src 'self'; img-src 'self' blob: data:; connect-src 'self'{socket};"
        " worker-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'self';"
        " frame-ancestors 'none'"
    )
    strict = (_STRICT,) if tls else ()
    return [("Content-Security-Policy", policy), *_ALWAYS, *strict]
