"""For an adapter: a protocol that a gateway speaks (entry point ``talaia.adapters``)."""

from __future__ import annotations

from talaia.extensions.adapter_host import (
    AdapterHost,
    CommandRefused,
    ConnectionLost,
    ExecutionFailed,
    ExtensionAdapter,
    ExtensionCommand,
    WantedSignal,
)
from talaia.extensions.declarations import AdapterExtension, ExtensionKeys

__all__ = [
    "AdapterExtension",
    "AdapterHost",
    "CommandRefused",
    "ConnectionLost",
    "ExecutionFailed",
    "ExtensionAdapter",
    "ExtensionCommand",
    "ExtensionKeys",
    "WantedSignal",
]
