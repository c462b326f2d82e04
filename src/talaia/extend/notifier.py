"""For a kind of server that messages about alarms go to (entry point ``talaia.notifiers``)."""

from __future__ import annotations

from talaia.extensions.declarations import (
    ExtensionKeys,
    NotDelivered,
    NotifierExtension,
    NotifierMessage,
)

__all__ = ["ExtensionKeys", "NotDelivered", "NotifierExtension", "NotifierMessage"]
