"""What can go wrong with an INDI server's words."""

from __future__ import annotations

from talaia.gateway.errors import GatewayError

__all__ = ["IndiError"]


class IndiError(GatewayError):
    """The server says what INDI does not allow, or more than is taken from one."""
