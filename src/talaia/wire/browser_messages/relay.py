"""A gateway's message as pages are told it: what both have, and the site."""

from __future__ import annotations

from functools import cache
from typing import TypeVar

from talaia.wire.message import Message

__all__ = ["relay_message", "shared_fields"]

_Update = TypeVar("_Update", bound=Message)


def relay_message(
    update: type[_Update], told: Message, site: str, **changed: str | float
) -> _Update:
    """Make the page's message ``update`` of what a gateway ``told`` of its ``site``.

    Only fields of the class that both are made from are repeated, so a field that a gateway's
    message alone has cannot reach a page. ``changed`` takes the place of some of them.
    """
    repeated = {name: getattr(told, name) for name in shared_fields(update, type(told))}
    # A shared field called ``site`` would raise here: a gateway cannot speak for another site.
    return update(site=site, **{**repeated, **changed})


# Asked for every message that is relayed; the pairs of classes are few and never change.
@cache
def shared_fields(update: type[Message], told: type[Message]) -> tuple[str, ...]:
    """Name the fields of the class that both messages are made from."""
    # Nearest first, so that the base with the fields is found before `Message` itself.
    shared = (base for base in update.__mro__ if issubclass(base, Message))
    return next(base for base in shared if issubclass(told, base)).__struct_fields__
