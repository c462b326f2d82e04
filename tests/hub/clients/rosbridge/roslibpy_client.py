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


def send_goal(ros, name: str, kind: str, args: dict) -> roslibpy.ActionClient:
    client = roslibpy.ActionClient(ros, name, kind)
    goal = client.send_goal(
        roslibpy.Goal(args),
        lambda found: note("result", {**found, "status": found["status"].value}),
        lambda found: note("feedback", dict(found)),
        lambda found: note("failed", str(found)),
    )
    note("sent", goal)
    return client


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
        elif what == "goal":
            kept.append(send_goal(ros, *rest))
        elif what == "cancel":
            roslibpy.ActionClient(ros, rest[0], "").cancel_goal(rest[1])
        elif what == "action_servers":
            ros.get_action_servers(lambda found: note("servers", found["action_servers"]))
        elif what == "publish":
            topic = roslibpy.Topic(ros, rest[0], rest[1])
            topic.publish(roslibpy.Message(rest[2]))
        else:
            note("found", getattr(ros, what)(*rest))
    ros.close()
    ros.terminate()


if __name__ == "__main__":
    main(sys.argv[1])
