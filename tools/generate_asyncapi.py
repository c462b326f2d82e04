"""Write docs/reference/asyncapi.yaml from the messages; ``--check`` compares it.

.venv/bin/python tools/generate_asyncapi.py [--check]
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path
from typing import Any, get_args

import msgspec
import yaml
from wire_words import CHANNELS

from talaia.wire import browser, frames

TARGET = Path(__file__).resolve().parent.parent / "docs" / "reference" / "asyncapi.yaml"
NOTE = "# Made from the code by tools/generate_asyncapi.py; do not edit.\n"
ROOMS = {"frames": frames, "browser": browser}
ABOUT = {
    "/gateway/link": "All but pictures between a gateway and its hub; the gateway dials.",
    "/gateway/media": "Pictures from a gateway.",
    "/gateway/files": "Recordings from a gateway; open only while it has any to hand over.",
    "/ws": "A page's socket: values, commands, driving. `?form=json` for the JSON form.",
    "/ws/media": "Pictures of one camera: `?site=…&stream=…`.",
    "/ws/topic": "One raw topic, read: `?site=…&topic=…&rate=…`.",
}


def document() -> dict[str, Any]:
    """Build the whole document."""
    shapes = sorted(
        {(room, shape) for _, _, room, union in CHANNELS for shape in members(room, union)},
        key=lambda each: (each[0], each[1].__name__),
    )
    refs, schemas = msgspec.json.schema_components(
        [shape for _, shape in shapes], ref_template="#/components/schemas/{name}"
    )
    names = {shape: f"{room}.{shape.__name__}" for room, shape in shapes}
    messages = {
        names[shape]: {
            "name": shape.__struct_config__.tag,
            "summary": (inspect.getdoc(shape) or "").split("\n\n")[0].replace("\n", " "),
            "payload": ref,
        }
        for (_, shape), ref in zip(shapes, refs, strict=True)
    }
    return {
        "asyncapi": "3.0.0",
        "info": {
            "title": "Talaia",
            # Of the tree: with each commit it would be another one.
            "version": "current",
            "description": "Messages as MessagePack maps (binary frames) or JSON (text frames);"
            " `t` names the kind. In JSON, bytes are base64. What each field means stands in"
            " wire.md.",
        },
        "defaultContentType": "application/vnd.msgpack",
        "servers": {"hub": {"host": "hub.example:8443", "protocol": "wss"}},
        "channels": channels(names),
        "operations": operations(names),
        "components": {
            "messages": messages,
            "schemas": schemas,
            "securitySchemes": {
                "gatewayKey": {"type": "http", "scheme": "bearer"},
                "session": {"type": "httpApiKey", "in": "cookie", "name": "talaia"},
            },
        },
    }


def members(room: str, union: str) -> tuple[type[msgspec.Struct], ...]:
    """Give the messages of a union; one alone is its own."""
    found = getattr(ROOMS[room], union)
    return get_args(found) or (found,)


def key_of(path: str) -> str:
    """Name a channel."""
    return path.strip("/").replace("/", "-")


def channels(names: dict[type, str]) -> dict[str, Any]:
    """Describe each path and what is said on it."""
    made: dict[str, Any] = {}
    for path, _, room, union in CHANNELS:
        one = made.setdefault(
            key_of(path), {"address": path, "description": ABOUT[path], "messages": {}}
        )
        for shape in members(room, union):
            name = names[shape]
            one["messages"][name] = {"$ref": f"#/components/messages/{name}"}
    return made


def operations(names: dict[type, str]) -> dict[str, Any]:
    """Say who sends what, as the hub sees it."""
    made = {}
    for path, title, room, union in CHANNELS:
        key = key_of(path)
        scheme = "gatewayKey" if path.startswith("/gateway") else "session"
        made[union[0].lower() + union[1:]] = {
            "action": "send" if title.startswith("Hub") else "receive",
            "summary": title,
            "channel": {"$ref": f"#/channels/{key}"},
            "security": [{"$ref": f"#/components/securitySchemes/{scheme}"}],
            "messages": [
                {"$ref": f"#/channels/{key}/messages/{names[shape]}"}
                for shape in members(room, union)
            ],
        }
    return made


def main(*, check_only: bool) -> int:
    """Write it, or compare it with what is there."""
    text = NOTE + yaml.safe_dump(document(), sort_keys=False, allow_unicode=True, width=100)
    if TARGET.exists() and TARGET.read_text() == text:
        return 0
    if check_only:
        print("docs/reference/asyncapi.yaml is not what the code says; run: make docs")
        return 1
    TARGET.write_text(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(check_only="--check" in sys.argv))
