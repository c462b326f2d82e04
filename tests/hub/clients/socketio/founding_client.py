"""PyPI's socketIO-client 0.7.2, unchanged, in a process of its own: it blocks while it waits.

Commands come as lines of JSON, events go out as lines of JSON.
"""

from __future__ import annotations

import json
import sys
import threading

import socketIO_client

_LOCK = threading.Lock()


def note(*event: object) -> None:
    with _LOCK:
        sys.stdout.write(json.dumps(event) + "\n")
        sys.stdout.flush()


class Namespace(socketIO_client.BaseNamespace):
    def on_event(self, event, *args):
        note(event, self.path, args[0] if args else None)

    def on_connect(self):
        note("connect", self.path, None)

    def on_disconnect(self):
        note("disconnect", self.path, None)

    def on_error(self, *args):
        note("connect_error", self.path, args[0] if args else "")


def main(address: str, query: str, transports: str, *namespaces: str) -> None:
    options = {} if transports == "default" else {"transports": transports.split(",")}
    client = socketIO_client.SocketIO(
        address, params=json.loads(query), wait_for_connection=False, **options
    )
    places = {namespace: client.define(Namespace, namespace) for namespace in namespaces}
    note("ready", "", client.transport_name)
    ended = threading.Event()

    def obey() -> None:
        for line in sys.stdin:
            namespace, event, *args = json.loads(line)
            if namespace == "close":
                break
            if namespace == "transport":
                note("transport", "", client.transport_name)
            elif args and args[-1] == "answer":
                place = places[namespace]
                place.emit(
                    event,
                    *args[:-1],
                    lambda *said, path=place.path: note("answered", path, said[0]),
                )
            else:
                places[namespace].emit(event, *args)
        ended.set()

    threading.Thread(target=obey, daemon=True).start()
    while not ended.is_set():
        client.wait(seconds=0.1)
    client.disconnect()


if __name__ == "__main__":
    main(*sys.argv[1:])
