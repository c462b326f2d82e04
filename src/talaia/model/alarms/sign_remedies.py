"""What is written in an expression instead of a sign that other languages have. Pure."""

from __future__ import annotations

__all__ = ["sign_remedy"]

_REMEDIES = {
    # One alone gives a name in most languages; here nothing is named.
    "=": "compare with ==",
    # Logic is written in words.
    "!": "write not, or != to compare",
    "&": "write and",
    "|": "write or",
    # Powers, of which there are none: a unit to a power that a signal has could not be checked.
    "*": "multiply a value with itself for its square",
    "^": "multiply a value with itself for its square",
    # Behind a number it is most often a share; a remainder there is none.
    "%": "leave the sign out: 80 is compared with what is in %",
    # As templates of other programs have them.
    "{": "write a signal in one pair of braces: {device/signal}",
    "}": "write a signal in one pair of braces: {device/signal}",
    "'": 'put texts in double quotes: "on"',
}


def sign_remedy(sign: str) -> str:
    """Say what to write instead of a sign that is not expected where it stands."""
    # Of others it is most often a bracket too many, or half of an operator.
    return _REMEDIES.get(sign, "see that signs and brackets are whole")
