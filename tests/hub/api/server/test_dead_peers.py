"""A connection whose other end is gone ends by itself."""

from __future__ import annotations

import socket
import sys

import pytest

from talaia.hub.api.server.dead_peers import drop_dead_peers


@pytest.mark.skipif(sys.platform != "linux", reason="these limits are Linux's")
def test_who_is_accepted_is_asked_whether_they_are_there_and_given_up_within_a_minute() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        drop_dead_peers(listener)
        with socket.create_connection(listener.getsockname()):
            accepted, _ = listener.accept()
            with accepted:
                assert accepted.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
                idle, every, times, sent_ms = (
                    accepted.getsockopt(socket.IPPROTO_TCP, option)
                    for option in (
                        socket.TCP_KEEPIDLE,
                        socket.TCP_KEEPINTVL,
                        socket.TCP_KEEPCNT,
                        socket.TCP_USER_TIMEOUT,
                    )
                )
    assert idle + every * times <= 60
    assert 0 < sent_ms <= 60_000
