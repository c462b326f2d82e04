"""The way to a network camera: to an address that was checked, and nowhere else.

The codec's own RTSP client looks the name up again, follows redirects, and sends packets to
whatever source a camera names. So it gets no camera's address at all: it speaks to a relay on this
computer, which resolves the name once, has every address checked, connects to one of them, and
reads each answer until the film plays. After PLAY that client follows nothing any more.

Source: RFC 2326 (RTSP 1.0), 4.2, 7, 10.4 and 12.39.
"""

from __future__ import annotations

import contextlib
import re
import selectors
import socket
import ssl
import threading
from typing import TYPE_CHECKING, Self
from urllib.parse import urlsplit, urlunsplit

from talaia.gateway.errors import GatewayError
from talaia.model.camera_addresses import remedy_for, why_no_camera

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["CameraRefused", "CameraRelay", "CameraResponseFilter", "addresses_of"]

_PORTS = {"rtsp": 554, "rtsps": 322}
_PIECE = 65_536
# No camera's answer is longer (bytes).
_MAX_HEAD, _MAX_BODY = 16_384, 1_048_576
_END = re.compile(rb"\n\r*\n")
_STATUS = re.compile(r"RTSP/1\.[01] ([1-5][0-9][0-9])(?: |\Z)")
_SOURCE = re.compile(r";\s*source\s*=[^;]*", re.IGNORECASE)


class CameraRefused(GatewayError):
    """A camera's address leads, or its server would lead, where no camera may be."""


def addresses_of(host: str, port: int, *, here: bool) -> list[str]:
    """Resolve a camera's name to numbers, all of which it may be at.

    Raises:
        CameraRefused: it may not be at one of them.
        OSError: nobody knows the name.

    """
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    addresses = list(dict.fromkeys(str(found_address[4][0]) for found_address in found))
    for address in addresses:
        why = why_no_camera(address, here=here)
        if why:
            raise CameraRefused(f"{host} is {address}, {why}; {remedy_for(why)}")
    return addresses


class CameraResponseFilter:
    """What a camera's server answers before the film plays, let through one by one. Pure.

    Lines end here as they do for the client behind, and are written anew, so that both read the
    same; whatever is not plainly an answer is refused.
    """

    def __init__(self, address: str) -> None:
        """Take the server's address, which it may not tell otherwise."""
        self._address = address
        self._got = b""

    def filter_bytes(self, data: bytes) -> bytes:
        """Give what may go on of what has come.

        Raises:
            CameraRefused: it leads elsewhere, or is no answer of RTSP.

        """
        self._got += data
        passed = b""
        while end := _END.search(self._got[:_MAX_HEAD]):
            head, size = self._filter_head(self._got[: end.start()])
            if len(self._got) < end.end() + size:
                break
            passed += head + self._got[end.end() : end.end() + size]
            self._got = self._got[end.end() + size :]
        else:
            if len(self._got) >= _MAX_HEAD:
                raise CameraRefused("it sends something that is not RTSP")
        return passed

    def take_rest(self) -> bytes:
        """Give what has not gone on yet."""
        rest, self._got = self._got, b""
        return rest

    def _filter_head(self, head: bytes) -> tuple[bytes, int]:
        first, *lines = head.replace(b"\r", b"").decode("latin-1").split("\n")
        status = _STATUS.match(first)
        if status is None:
            raise CameraRefused("it sends something that is not RTSP")
        if status[1].startswith("3"):
            raise CameraRefused(
                "its server sends on to another address, which is not followed; "
                "write that address into the description if it is the camera"
            )
        sizes, kept = [], [first]
        for line in lines:
            key, _, value = line.partition(":")
            word = key.strip().lower()
            if word == "content-length":
                sizes.append(value.strip())
            kept.append(self._filter_transport(line) if word == "transport" else line)
        size = int(sizes[0]) if sizes and re.fullmatch(r"[0-9]{1,7}", sizes[0]) else 0
        if len(sizes) > 1 or (sizes and str(size) != sizes[0]) or size > _MAX_BODY:
            raise CameraRefused("it does not say how long its answer is")
        return ("\r\n".join(kept) + "\r\n\r\n").encode("latin-1"), size

    def _filter_transport(self, line: str) -> str:
        # The client sends packets to the source that is named here: never another.
        if "," in line:
            raise CameraRefused("it answers with several ways to send its film")
        return f"{_SOURCE.sub('', line)};source={self._address}"


class CameraRelay:
    """A connection to one camera, and a port of this computer that leads to it, for one client.

    A context manager, and a thread while it lasts.
    """

    def __init__(self, url: str, *, here: bool, timeout: float) -> None:
        """Reach the camera at an address (without a password), within a time (s).

        Raises:
            CameraRefused: no camera may be there.
            OSError: it cannot be reached.

        """
        parts = urlsplit(url)
        host, port = parts.hostname or "", parts.port or _PORTS[parts.scheme]
        self._far = _connect_any(addresses_of(host, port, here=here), port, timeout)
        try:
            if parts.scheme == "rtsps":
                self._far = _wrap_tls(self._far, host)
            address, *_ = self._far.getpeername()
            self._answers = CameraResponseFilter(address)
            v6 = self._far.family == socket.AF_INET6
            near = "::1" if v6 else "127.0.0.1"
            self._door = socket.create_server((near, 0), family=self._far.family, backlog=1)
        except BaseException:
            self._far.close()
            raise
        self._door.settimeout(timeout)
        own = self._door.getsockname()[1]
        place = f"[::1]:{own}" if v6 else f"127.0.0.1:{own}"
        self.url = urlunsplit(parts._replace(scheme="rtsp", netloc=place))
        self.refusal: CameraRefused | None = None
        self._wake, self._ended = socket.socketpair()
        self._thread = threading.Thread(target=self._run_relay, name="talaia-relay", daemon=True)

    def __enter__(self) -> Self:
        """Begin."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Hang up."""
        self._wake.close()
        with contextlib.suppress(OSError):
            self._door.shutdown(socket.SHUT_RDWR)
        self._thread.join()

    def _run_relay(self) -> None:
        with self._door, self._far, self._ended, contextlib.suppress(OSError):
            near, _ = self._door.accept()
            self._door.close()
            near.settimeout(self._door.gettimeout())
            # Pictures wait for no acknowledgement.
            near.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, True)  # noqa: FBT003 - its shape
            with near:
                try:
                    self._carry_data(near)
                except CameraRefused as error:
                    self.refusal = error

    def _carry_data(self, near: socket.socket) -> None:
        playing = False
        with selectors.DefaultSelector() as ready:
            for connection in (near, self._far, self._ended):
                ready.register(connection, selectors.EVENT_READ)
            while True:
                speaking = [key.fileobj for key, _ in ready.select()]
                if self._ended in speaking:
                    return
                if near in speaking:
                    asked = near.recv(_PIECE)
                    if not asked:
                        return
                    if not playing and asked.startswith(b"PLAY "):
                        playing = True
                        near.sendall(self._answers.take_rest())
                    self._far.sendall(asked)
                if self._far in speaking and not self._pass_on(near, playing=playing):
                    return

    def _pass_on(self, near: socket.socket, *, playing: bool) -> bool:
        """Carry what has come from the camera; false when it has hung up."""
        while (got := self._receive_data()) is not None:
            if not got:
                return False
            near.sendall(got if playing else self._answers.filter_bytes(got))
            # What is decrypted already wakes no selector.
            if not isinstance(self._far, ssl.SSLSocket) or not self._far.pending():
                break
        return True

    def _receive_data(self) -> bytes | None:
        """Give what the camera has sent, nothing when it has hung up, `None` for no words yet.

        An encrypted line wakes us for a ticket, or for a part of a record, which hold no words:
        who waited for some here would keep the client's next question from the camera.
        """
        patience = self._far.gettimeout()
        self._far.settimeout(0)
        try:
            return self._far.recv(_PIECE)
        except (ssl.SSLWantReadError, BlockingIOError):
            return None
        finally:
            self._far.settimeout(patience)


def _connect_any(addresses: Iterable[str], port: int, timeout: float) -> socket.socket:
    problem: OSError | None = None
    for address in addresses:
        try:
            return socket.create_connection((address, port), timeout)
        except OSError as error:
            problem = error
    raise problem or OSError("it has no address")


def _wrap_tls(far: socket.socket, host: str) -> ssl.SSLSocket:
    # Cameras sign their certificates themselves: the line is secret, not proven.
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return context.wrap_socket(far, server_hostname=host)
