"""A network camera: RTSP over one TCP connection (RFC 2326), H.264 in RTP (RFC 6184)."""

from __future__ import annotations

import base64
import contextlib
import re
import socket
import ssl
import struct
import threading
from collections.abc import Iterator

import numpy as np

from talaia.gateway.video.h264 import Encoder
from talaia.gateway.video.pixels import Pixels

PIECE = 1200
CLOCK = 90_000


class RtspCamera:
    """Serves one client after the other the same film, over and over, at 20 Hz."""

    def __init__(
        self,
        pictures: list[np.ndarray],
        user: str = "",
        *,
        tls: ssl.SSLContext | None = None,
        source: str = "",
    ) -> None:
        """Take the film as RGB, and ``name:password`` to ask for, if any.

        Args:
            pictures: the film.
            user: whom it serves.
            tls: encrypt with this.
            source: where it says that packets come from, where they go by UDP.

        """
        height, width = pictures[0].shape[:2]
        encoder = Encoder(width=width, height=height, rate=20, bits=4_000_000)
        self._film: list[list[bytes]] = []
        for at, each in enumerate(pictures):
            made = encoder.encode_picture(
                Pixels("RGB", width, height, each), at * 50_000, key=at == 0
            )
            assert made is not None
            self._film.append(list(units_of(made.data)))
        self._user = user
        self._tls, self._source = tls, source
        self.lossy = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.lossy.bind(("127.0.0.1", 0))
        self._to: tuple[str, int] | None = None
        self._ended = threading.Event()
        self.clients = 0
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        self._now: socket.socket | None = None
        threading.Thread(target=self._run, daemon=True).start()

    def close(self) -> None:
        self._ended.set()
        # Only this wakes a thread that waits for a client.
        with contextlib.suppress(OSError):
            socket.create_connection(("127.0.0.1", self.port)).close()
        self.drop()
        self._socket.close()
        self.lossy.close()

    def drop(self) -> None:
        """Cut the connection there is."""
        if self._now is not None:
            with contextlib.suppress(OSError):
                self._now.shutdown(socket.SHUT_RDWR)

    def _run(self) -> None:
        while not self._ended.is_set():
            client, _ = self._socket.accept()
            with contextlib.suppress(OSError), contextlib.ExitStack() as stack:
                stack.enter_context(client)
                if self._tls is not None and not self._ended.is_set():
                    client = stack.enter_context(self._tls.wrap_socket(client, server_side=True))
                self._now = client
                self._serve(client)

    def _serve(self, client: socket.socket) -> None:
        reader = client.makefile("rb")
        while True:
            lines = []
            while line := reader.readline().strip():
                lines.append(line.decode())
            if not lines:
                return
            verb = lines[0].split()[0]
            heads = {k.lower(): v for k, _, v in (each.partition(": ") for each in lines[1:])}
            answer, more, body = "200 OK", "", ""
            wanted = "Basic " + base64.b64encode(self._user.encode()).decode()
            if self._user and verb != "OPTIONS" and heads.get("authorization") != wanted:
                answer, more = "401 Unauthorized", 'WWW-Authenticate: Basic realm="camera"\r\n'
            elif verb == "DESCRIBE":
                body = (
                    "v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=c\r\nt=0 0\r\nm=video 0 RTP/AVP 96\r\n"
                    f"a=rtpmap:96 H264/{CLOCK}\r\na=fmtp:96 packetization-mode=1\r\na=control:t\r\n"
                )
                more = "Content-Type: application/sdp\r\n"
            elif verb == "SETUP":
                more = f"Transport: {self._transport(heads['transport'])}\r\nSession: 1\r\n"
            elif verb == "PLAY":
                more = "Session: 1\r\n"
            client.sendall(
                f"RTSP/1.0 {answer}\r\nCSeq: {heads.get('cseq', '0')}\r\n{more}"
                f"Content-Length: {len(body)}\r\n\r\n{body}".encode()
            )
            if verb == "PLAY" and answer.startswith("200"):
                self.clients += 1
                self._play(client)
                return

    def _transport(self, wanted: str) -> str:
        ports = re.search(r"client_port=([0-9]+)-([0-9]+)", wanted)
        if ports is None:
            return "RTP/AVP/TCP;unicast;interleaved=0-1"
        self._to = ("127.0.0.1", int(ports[1]))
        own = self.lossy.getsockname()[1]
        return f"RTP/AVP;unicast;{ports[0]};server_port={own}-{own};source={self._source}"

    def _play(self, client: socket.socket) -> None:
        number = at = 0
        while not self._ended.is_set():
            units = self._film[at % len(self._film)]
            for last, unit in ((each is units[-1], each) for each in units):
                for payload, end in packets_of(unit):
                    mark = 0x80 if last and end else 0
                    head = struct.pack(
                        ">BBHII", 0x80, 96 | mark, number % 65536, at * CLOCK // 20, 7
                    )
                    packet = head + payload
                    if self._to is None:
                        client.sendall(b"$\0" + struct.pack(">H", len(packet)) + packet)
                    else:
                        self.lossy.sendto(packet, self._to)
                    number += 1
            at += 1
            self._ended.wait(0.05)


def units_of(data: bytes) -> Iterator[bytes]:
    """Cut Annex B into its units."""
    for part in data.split(b"\0\0\1")[1:]:
        yield part.rstrip(b"\0")


def packets_of(unit: bytes) -> Iterator[tuple[bytes, bool]]:
    """Cut a unit as RTP wants it: whole, or in fragments (FU-A); true with the last."""
    if len(unit) <= PIECE:
        yield unit, True
        return
    kind, nri, rest = unit[0] & 31, unit[0] & 0x60, unit[1:]
    for begin in range(0, len(rest), PIECE):
        end = begin + PIECE >= len(rest)
        flags = (0x80 if begin == 0 else 0) | (0x40 if end else 0)
        yield bytes([nri | 28, flags | kind]) + rest[begin : begin + PIECE], end
