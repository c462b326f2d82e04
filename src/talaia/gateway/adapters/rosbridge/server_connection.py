"""How a rosbridge server is dialled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from websockets.asyncio.client import connect

if TYPE_CHECKING:
    import ssl
    from collections.abc import Mapping

__all__ = ["dial_server"]

# A lost server is told within two seconds, long before values grow old.
_PING_S, _PONG_S, _OPEN_S = 0.7, 1.2, 3.0


def dial_server(
    url: str, headers: Mapping[str, str], tls: ssl.SSLContext | None, *, max_size: int
) -> connect:
    """Give a connection to be entered; frames of more than ``max_size`` bytes end it."""
    return connect(
        url,
        additional_headers=headers,
        ssl=tls,
        ping_interval=_PING_S,
        ping_timeout=_PONG_S,
        open_timeout=_OPEN_S,
        close_timeout=0.5,
        max_size=max_size,
        # Pictures are compressed already, and packing them costs the robot's processor.
        compression=None,
        # The robot stands in the same network, whatever the environment names.
        proxy=None,
    )
