"""The second factor: codes of time (TOTP, RFC 6238) and recovery codes. Pure but for chance."""

from __future__ import annotations

import base64
import hmac
import io
import secrets

import pyotp
import segno

from talaia.hub.auth.tokens import hash_token

__all__ = [
    "RECOVERY_CODES",
    "hash_recovery",
    "new_factor",
    "new_recovery",
    "otp_uri",
    "qr_svg",
    "step_of",
]

RECOVERY_CODES = 10  # as many as are shown, and kept, when a factor is set
# Seconds that a code stands for.
_STEP_S = 30
# A code of the step before or after is taken too: clocks differ, and typing takes time.
_SLACK = (0, -1, 1)
# 120 bits: a plain hash of so much chance cannot be guessed.
_RECOVERY_BYTES = 15
# For whoever copies them from paper: six groups of four.
_GROUP = 4
_ISSUER = "Talaia"  # what authenticators show above the person's name


def new_factor() -> str:
    """Make a secret (160 bits, base 32) for an authenticator."""
    return pyotp.random_base32()


def otp_uri(secret: str, name: str) -> str:
    """Give the ``otpauth:`` URI that authenticators read."""
    return pyotp.TOTP(secret).provisioning_uri(name=name, issuer_name=_ISSUER)


def qr_svg(text: str) -> str:
    """Draw a QR code as an SVG element, dark on light, with no script and no style in it."""
    drawn = io.BytesIO()
    # Medium correction; not every authenticator reads a Micro QR code.
    segno.make(text, error="m", micro=False).save(
        drawn, kind="svg", border=4, scale=4, dark="#000", light="#fff", xmldecl=False, nl=False
    )
    return drawn.getvalue().decode()


def step_of(secret: str, code: str, now_s: float) -> int | None:
    """Tell of which step of time ``code`` is, near ``now_s`` (s since the epoch); None: of none.

    Whoever takes a code keeps its step, and takes none of that step or before it again.
    """
    # Authenticators show two groups of three digits.
    typed = code.strip().replace(" ", "")
    # `hmac.compare_digest` raises at a text that is not ASCII.
    if not (typed.isascii() and typed.isdecimal()):
        return None
    totp = pyotp.TOTP(secret, interval=_STEP_S)
    # RFC 6238, 4.2: steps of 30 s, counted from the epoch.
    here = int(now_s) // _STEP_S
    # Every step is looked at, so that the time it takes tells nothing.
    found = [
        step
        for step in (here + slack for slack in _SLACK)
        if hmac.compare_digest(totp.generate_otp(max(0, step)), typed)
    ]
    return found[0] if found else None


def new_recovery() -> list[str]:
    """Make the recovery codes; each opens once in place of a code of time."""
    return [_recovery_code() for _ in range(RECOVERY_CODES)]


def hash_recovery(code: str) -> str:
    """Give what is kept of a recovery code, however it was typed."""
    # Groups and case are for the eye only.
    return hash_token("".join(character for character in code.lower() if character.isalnum()))


def _recovery_code() -> str:
    text = base64.b32encode(secrets.token_bytes(_RECOVERY_BYTES)).decode().lower()
    return "-".join(text[at : at + _GROUP] for at in range(0, len(text), _GROUP))
