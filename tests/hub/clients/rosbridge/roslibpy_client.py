"""PyPI's roslibpy in a process of its own: its reactor starts once in a process.

Commands come as lines of JSON, events go out as lines of JSON.
"""

from __future__ import annotations

import json
import sys
import threading

import roslibpy

_LOCK = threading.Lock()


def note(event: str, data: object) -> None:
    with _LOCK:
        sys.stdout.write(json.dumps([event, data], default=dict) + "\n")
        sys.stdout.flush()


def main(address: str) -> None:
    ros = roslibpy.Ros(host=address)
    ros.run(timeout=60)
    note("connected", ros.is_connected)
    kept = []
    for line in sys.stdin:
        what, *rest = json.loads(line)
        if what == "subscribe":
            topic = roslibpy.Topic(ros, rest[0], rest[1])
            topic.subscribe(lambda message, name=rest[0]: note("message", [name, dict(message)]))
            kept.append(topic)
        elif what == "call":
            service = roslibpy.Service(ros, rest[0], rest[1])
            service.call(
                roslibpy.ServiceRequest(rest[2]),
                callback=lambda found: note("called", dict(found)),
                errback=lambda why: note("failed", str(why)),
            )
        elif what == "publish":
            topic = roslibpy.Topic(ros, rest[0], rest[1])
            topic.publish(roslibpy.Message(rest[2]))
        else:
            note("found", getattr(ros, what)(*rest))
    ros.close()
    ros.terminate()


if __name__ == "__main__":
    main(sys.argv[1])
