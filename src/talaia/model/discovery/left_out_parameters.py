"""Which parameters of a robot are left out of a description, and why. Pure."""

from __future__ import annotations

import re

__all__ = ["is_secret", "reason_to_leave"]

# Texts are read once a second: what is longer (a robot's model) is for tools.
_MAX_TEXT = 200
# Of a list as text: sixteen numbers with all their digits fit.
_MAX_LIST = 400
_LISTS = ("numbers", "integers", "booleans", "texts", "bytes")
# Parts of names whose values nobody should have on a page.
_SECRETS = (
    "password",
    "passwd",
    "passphrase",
    "secret",
    "token",
    "credential",
    "api_key",
    "apikey",
    "private_key",
    "privatekey",
)
# The same, as a whole word: a keyframe is no secret.
_SECRET_WORDS = {"key", "keys", "pwd"}
_BETWEEN_WORDS = re.compile(r"[^a-z0-9]+")


def is_secret(name: str) -> bool:
    """Tell whether a parameter is a secret by its name, name spaces included."""
    lower = name.lower()
    words = set(_BETWEEN_WORDS.split(lower))
    return bool(words & _SECRET_WORDS) or any(part in lower for part in _SECRETS)


def reason_to_leave(name: str, kind: str | None, length: int = 0) -> str:
    """Say why a parameter is left out; empty where it is not.

    Args:
        name: of the parameter.
        kind: ``number``, ``integer``, ``boolean`` or ``text``, or several of one of these (see
            `ParameterFound`); none: it is something else.
        length: of a text, or of a list as text, in characters.

    """
    if is_secret(name):
        # Its value would be asked for each second, and shown to all who may look.
        return "by its name it is a secret"
    if kind is None:
        return "it is no number, truth or text, nor a list of one of these"
    if kind == "text" and length > _MAX_TEXT:
        return f"a text of {length} characters"
    if kind in _LISTS and length > _MAX_LIST:
        return f"a list that takes {length} characters"
    return ""
