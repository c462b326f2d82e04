"""An Alpaca server made from ASCOM's API text, for what alpaca-simulators do not show.

Its devices are plain values that a test sets; what it is told to do wrong it does: silence, errors,
states of HTTP. Unlike the simulators it has a management API and a camera without a sky.
"""

from __future__ import annotations

import http.server
import json
import struct
import threading
from collections import Counter
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl, urlsplit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class AlpacaStandIn:
    """What its devices have, and what was put there.

    Attributes:
        values: by address behind ``/api/v1/``, with its query.
        errors: by address: ASCOM's number and words, or a status of HTTP below 600.
        asked: how often each address was asked for.
        puts: methods that were called, with their parameters.
        on_put: what a method does, by address.
        silent: addresses that never answer while the test lasts.
        end: ends the server; nobody can connect any more.

    """

    def __init__(self) -> None:  # noqa: D107
        self.values: dict[str, object] = {}
        self.errors: dict[str, tuple[int, str]] = {}
        self.asked: Counter[str] = Counter()
        self.puts: list[tuple[str, dict[str, str]]] = []
        self.on_put: dict[str, Callable[[dict[str, str]], None]] = {}
        self.silent: set[str] = set()
        self.released = threading.Event()
        self.picture = b""
        self.end: Callable[[], None] = lambda: None

    def calls(self, address: str) -> int:
        return sum(1 for put, _ in self.puts if put == address)


def image_bytes(columns: list[list[int]], *, kind: int = 8, error: int = 0) -> bytes:
    """Write ImageBytes as ASCOM's text has it: ``columns[x][y]``."""
    shape = (len(columns), len(columns[0]))
    head = struct.pack("<iiIIiiiiiii", 1, error, 7, 8, 44, 2, kind, 2, *shape, 0)
    form = {8: "H", 2: "i", 6: "B"}[kind]
    return head + b"".join(struct.pack(f"<{shape[1]}{form}", *column) for column in columns)


@contextmanager
def serving_alpaca() -> Iterator[tuple[int, AlpacaStandIn]]:
    """Serve; give the port and what is served."""
    stand_in = AlpacaStandIn()

    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            parts = urlsplit(self.path)
            if parts.path == "/management/v1/configureddevices":
                self._answer(_configured(stand_in.values))
                return
            query = dict(parse_qsl(parts.query))
            number = int(query.pop("ClientTransactionID", "0"))
            query.pop("ClientID", "")
            more = "?" + "&".join(f"{key}={value}" for key, value in query.items()) if query else ""
            address = parts.path.removeprefix("/api/v1/") + more
            stand_in.asked[address] += 1
            if address.endswith("/imagearray") and stand_in.picture:
                self._send(200, stand_in.picture, "application/imagebytes")
                return
            self._answer_for(address, number, stand_in.values.get(address))

        def do_PUT(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"])).decode()
            fields = dict(parse_qsl(body))
            number = int(fields.pop("ClientTransactionID"))
            fields.pop("ClientID")
            address = urlsplit(self.path).path.removeprefix("/api/v1/")
            stand_in.puts.append((address, fields))
            if f"PUT {address}" not in stand_in.errors:
                stand_in.on_put.get(address, lambda _: None)(fields)
            self._answer_for(f"PUT {address}", number, None, known=True)

        def _answer_for(
            self, address: str, number: int, value: object, *, known: bool = False
        ) -> None:
            if address in stand_in.silent:
                stand_in.released.wait()
            error, words = stand_in.errors.get(address, (0, ""))
            if 0 < error < 600:
                self._send(error, words.encode(), "text/plain")
                return
            if not error and not known and address not in stand_in.values:
                error, words = 0x400, "not implemented"
            answer = {"ClientTransactionID": number, "ServerTransactionID": 1}
            self._answer({**answer, "ErrorNumber": error, "ErrorMessage": words, "Value": value})

        def _answer(self, value: dict[str, Any]) -> None:
            self._send(200, json.dumps(value).encode(), "application/json")

        def _send(self, status: int, body: bytes, kind: str) -> None:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()

        def end() -> None:
            server.shutdown()
            server.socket.close()

        stand_in.end = end
        try:
            yield server.server_address[1], stand_in
        finally:
            stand_in.released.set()
            server.shutdown()
            thread.join()


def _configured(values: dict[str, object]) -> dict[str, Any]:
    devices = dict.fromkeys("/".join(address.split("/")[:2]) for address in values)
    return {
        "Value": [
            {
                "DeviceName": str(values.get(f"{device}/name", device)),
                "DeviceType": device.partition("/")[0].capitalize(),
                "DeviceNumber": int(device.partition("/")[2]),
                "UniqueID": device,
            }
            for device in devices
        ]
    }
