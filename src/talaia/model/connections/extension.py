"""A protocol that an extension speaks; what its keys must be is the extension's to say."""

from __future__ import annotations

from talaia.model.base import Shape, SourceShape
from talaia.model.closed_lists import CommandKind
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules

__all__ = ["ExtensionConnection", "ExtensionKindRules", "ExtensionScalar", "ExtensionSource"]

ExtensionScalar = bool | int | float | str


class ExtensionConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="extension"):
    """A protocol that an extension speaks, which is installed at the gateway.

    Attributes:
        extension: its name, as ``talaia extensions`` lists it: ``snmp``.
        keys: what the extension asks for, by its own names; ``talaia extensions`` lists them. A
            hub on which it is not installed keeps them as they are.

    """

    extension: str
    keys: dict[str, ExtensionScalar] = {}


class ExtensionSource(SourceShape, frozen=True, kw_only=True, tag="extension"):
    """Where a signal comes from that an extension reads.

    Attributes:
        keys: what the extension of the connection asks for, by its own names.

    """

    keys: dict[str, ExtensionScalar] = {}


class ExtensionKindRules(KindRules[ExtensionConnection, ExtensionSource]):
    """Checks no more than the kind: see `checks.extension_rules` for what is installed."""

    kind = ConnectionKind.EXTENSION
    source = ExtensionSource
    example = "keys: {…}"
    commands = frozenset({CommandKind.EXTENSION})

    def __init__(self, connection: ExtensionConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, ExtensionSource)
