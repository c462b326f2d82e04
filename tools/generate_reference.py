"""Write docs/reference from the code; ``--check`` says whether what is there is what it would be.

.venv/bin/python tools/generate_reference.py [--check]
"""

from __future__ import annotations

import inspect
import json
import re
import subprocess
import sys
import tempfile
import textwrap
from enum import StrEnum
from pathlib import Path
from typing import Any, get_args

import msgspec
from wire_words import CHANNELS, CLOSE_CODES, limits, meaning

from talaia.cli.main import COMMANDS
from talaia.clock import SystemClock
from talaia.hub.api.openapi import describe_api, needs_in_words
from talaia.hub.app import build_hub
from talaia.hub.settings import Settings
from talaia.model import ai_services, connection, night_section as night, roles, site
from talaia.model.base import FOREIGN_KEYS, SourceShape
from talaia.model.schema import site_schema
from talaia.model.units.unit import UNITS
from talaia.wire import browser, frames

CODECS = {
    "FromGateway": frames.LINK_FROM_GATEWAY,
    "FromHub": frames.LINK_FROM_HUB,
    "MediaFromGateway": frames.MEDIA_FROM_GATEWAY,
    "MediaFromHub": frames.MEDIA_FROM_HUB,
    "FilesFromGateway": frames.FILES_FROM_GATEWAY,
    "FilesFromHub": frames.FILES_FROM_HUB,
    "FromBrowser": browser.FROM_BROWSER,
    "ToBrowser": browser.TO_BROWSER,
    "MediaToBrowser": browser.MEDIA_TO_BROWSER,
    "MediaFromBrowser": browser.MEDIA_FROM_BROWSER,
    "TopicToBrowser": browser.TOPIC_TO_BROWSER,
    "TopicFromBrowser": browser.TOPIC_FROM_BROWSER,
}
WIRE = """A binary frame is a MessagePack map, a text frame the same as JSON (bytes as base64);
`t` is the message's kind, written below its name. Fields a reader does not know are ignored,
fields it misses take their defaults, and kinds it does not know are skipped once hello and welcome
are said: so version N talks with N-1 and N+1. A frame over its limit, or with a field over its
own, closes the connection. [asyncapi.yaml](asyncapi.yaml) says the same to programs."""
ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "docs" / "reference"
# Lists that are too long for a cell: their section on the same page.
ROLE_TABLES: dict[type, str] = {
    roles.SignalRole: "roles of signals",
    roles.CommandRole: "roles of commands",
}
NIGHT_SHAPES: tuple[type[msgspec.Struct], ...] = (
    *(
        night.NightSection,
        night.SlewCommand,
        night.PointCommand,
        night.FrameCommand,
        night.FilterCommand,
    ),
    *(night.SettingCommand, night.NightFlats),
    *(night.NightDarks, night.NightSun, night.Instrument),
)
# One example for each key, by section; the tests hold it against the shapes.
EXAMPLES = ROOT / "tools/description_examples.yaml"
NOTE = "<!-- Made from the code by tools/generate_reference.py; do not edit. -->\n\n"


def main(*, check_only: bool) -> int:
    """Write every page, or compare it with what is there."""
    pages = {
        "site-description.md": site_page(),
        "wire.md": wire_page(),
        "commands.md": commands_page(),
        "http.md": http_page(),
        "openapi.json": json.dumps(api(), indent=2, ensure_ascii=False) + "\n",
        "site.schema.json": json.dumps(site_schema(), indent=2, ensure_ascii=False) + "\n",
    }
    stale = []
    TARGET.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        path = TARGET / name
        if path.exists() and path.read_text() == text:
            continue
        stale.append(name)
        if not check_only:
            path.write_text(text)
    if stale and check_only:
        print(f"docs/reference is not what the code says: {', '.join(stale)}; run: make docs")
        return 1
    print(f"docs/reference: {len(pages)} pages, {len(stale)} {'written' if stale else 'changed'}")
    return 0


def site_shapes() -> list[type[msgspec.Struct]]:
    """List every part of the site description, in the order of its page."""
    shapes = [
        *(site.Site, site.Ros2Settings, *get_args(connection.Connection)),
        *(site.Device, site.Signal, *get_args(connection.Source), site.Stream, site.Command),
        *(site.Argument, site.Drive, site.DrivenJoint, site.Stop, ai_services.AiServices),
        *NIGHT_SHAPES,
    ]
    return insert_parts(shapes)


def site_page() -> str:
    """Describe every key of the site description."""
    examples = read_examples(EXAMPLES.read_text())
    parts = [
        NOTE + "# Site description\n",
        "One YAML file says all there is to know of a site. `talaia check FILE` says whether it is"
        " right; [site.schema.json](site.schema.json) lets an editor complete it.\n",
        *(struct_section(shape) + example_of(shape, examples) for shape in site_shapes()),
        *roles_sections(),
        "## Units\n",
        table(
            ("symbol", "name"),
            [(f"`{u.symbol}`" if u.symbol else "", u.name) for u in UNITS.values()],
        ),
    ]
    return "\n".join(parts)


def read_examples(text: str) -> dict[str, str]:
    """Cut the file of examples into its sections: each as it was written, two columns less in."""
    sections = re.split(r"(?m)^(\w+):\n", text)[1:]
    return {
        name: textwrap.dedent(body).strip()
        for name, body in zip(sections[::2], sections[1::2], strict=True)
    }


def example_of(shape: type[msgspec.Struct], examples: dict[str, str]) -> str:
    """Show each key of a part of the description with an example."""
    tag = msgspec.inspect.type_info(shape).tag  # type: ignore[attr-defined]
    kind = f"kind: {tag}\n" if isinstance(tag, str) and not issubclass(shape, SourceShape) else ""
    said = "Each key by an example; not all of them go together:"
    return f"\n{said}\n\n```yaml\n{kind}{examples[shape.__name__]}\n```\n"


def insert_parts(shapes: list[type[msgspec.Struct]]) -> list[type[msgspec.Struct]]:
    """Add each struct that a listed one holds and nobody listed, right behind its first holder."""
    listed = set(shapes)
    described: list[type[msgspec.Struct]] = []
    waiting = list(reversed(shapes))
    while waiting:
        shape = waiting.pop()
        described.append(shape)
        found = dict.fromkeys(part for part in held_structs(shape) if part not in listed)
        listed |= set(found)
        waiting += reversed(found)
    return described


def held_structs(shape: type[msgspec.Struct]) -> list[type[msgspec.Struct]]:
    """List the structs that the fields of one may hold."""
    info = msgspec.inspect.type_info(shape)
    if not isinstance(info, msgspec.inspect.StructType):
        raise TypeError(f"{shape} is not a struct")
    return [part for field in info.fields for part in structs_in(field.type)]


def roles_sections() -> list[str]:
    """Describe every role: what it stands on, and what the states of such a signal may mean."""
    signals = [
        (
            f"`{role.value}`",
            " or ".join(fit.types) + (f" in {' or '.join(fit.units)}" if fit.units else ""),
            ", ".join(f"`{meaning.value}`" for meaning in fit.meanings),
            "any number" if fit.many else "one",
        )
        for role, fit in roles.SIGNAL_FITS.items()
    ]
    commands = [
        (
            f"`{role.value}`",
            ", or ".join(fit.forms) + (f" in {fit.unit}" if fit.unit else ""),
            "any number" if fit.many else "one",
        )
        for role, fit in roles.COMMAND_FITS.items()
    ]
    return [
        "## Roles of signals\n",
        "Beside these, `auto` takes what Talaia proposes and `none` has no role; what they are for:"
        " [Describe a robot](../how-to/configure.md#roles).\n",
        table(("role", "stands on", "`meanings` of its states", "of a device"), signals),
        "## Roles of commands\n",
        "An outlet is switched by the command of its own id, or by two whose ids end in `_on` and"
        " `_off`. Of a command with `telescope.goto` the site's `pointing` says which arguments"
        " are right ascension and declination.\n",
        table(("role", "asks for", "of a device"), commands),
    ]


def wire_page() -> str:
    """Describe every message, by who sends it."""
    rooms = {"frames": frames, "browser": browser}
    parts = [NOTE + "# Messages\n", (inspect.getdoc(frames) or "") + "\n", WIRE + "\n"]
    codes = [(str(code), who, what) for code, who, what in CLOSE_CODES]
    parts += ["## Close codes\n", table(("code", "sent by", "meaning"), codes)]
    for path, title, room, name in CHANNELS:
        union = getattr(rooms[room], name)
        codec = CODECS[name]
        parts.append(f"## {title}, `{path}`\n\nA frame is at most {codec.max_frame:,} bytes.\n")
        parts += [struct_section(s, "###", wire=True) for s in (get_args(union) or (union,))]
    parts += ["## Parts of messages\n", *(struct_section(s, "###") for s in parts_of_messages())]
    return "\n".join(parts)


def parts_of_messages() -> list[type[msgspec.Struct]]:
    """List the structs that stand in messages and are none, by name."""
    rooms = {"frames": frames, "browser": browser}
    unions = [getattr(rooms[room], name) for _, _, room, name in CHANNELS]
    messages = {shape for union in unions for shape in (get_args(union) or (union,))}
    known: dict[type[msgspec.Struct], None] = dict.fromkeys(messages)
    for waiting in (queue := [*messages]):
        found = dict.fromkeys(held_structs(waiting))
        queue += [s for s in found if s not in known]
        known |= found
    return sorted(known.keys() - messages, key=lambda shape: shape.__name__)


def structs_in(kind: msgspec.inspect.Type) -> list[type[msgspec.Struct]]:
    """List the structs that a field may hold."""
    match kind:
        case msgspec.inspect.StructType():
            return [kind.cls]
        case msgspec.inspect.ListType() | msgspec.inspect.VarTupleType():
            return structs_in(kind.item_type)
        case msgspec.inspect.DictType():
            return structs_in(kind.value_type)
        case msgspec.inspect.UnionType():
            return [s for each in kind.types for s in structs_in(each)]
        case _:
            return []


def commands_page() -> str:
    """Show the help of every word of the command line."""
    parts = [NOTE + "# The `talaia` command\n"]
    for name in sorted([*COMMANDS, "gateway enrol"], key=ordered):
        done = subprocess.run(
            [sys.executable, "-m", "talaia", *name.split(), "--help"],
            capture_output=True, text=True, check=True, env={**child_environment()},
        )  # fmt: skip
        parts.append(f"## talaia {name}\n\n```text\n{done.stdout.strip()}\n```\n")
    return "\n".join(parts)


def api() -> dict[str, Any]:
    """Describe the HTTP API; the hub is only put together for it, and nothing is opened."""
    with tempfile.TemporaryDirectory() as folder:
        hub = build_hub(Settings(data=Path(folder)), SystemClock())
    described = describe_api(hub.app)
    # Of the tree: with each commit it would be another one.
    described["info"]["version"] = "current"
    return described


def http_page() -> str:
    """List every route with the right it needs."""
    rows = ["| route | what it does | it needs |", "|---|---|---|"]
    for path, methods in api()["paths"].items():
        for method, said in methods.items():
            what = said["description"].partition("\n\n")[0].replace("\n", " ").replace("``", "`")
            need = needs_in_words(method.upper(), path)
            rows.append(f"| `{method.upper()} {path}` | {what} | {need} |")
    head = (
        "# HTTP API\n\nEvery route, with what it takes to be answered. A script finds the bodies"
        " and all answers in [openapi.json](openapi.json). A body is JSON; an answer that says no"
        " is `{code, message}`: a word for programs and a sentence for people. Times ending in"
        " `_us` are microseconds since the epoch (UTC).\n\n"
    )
    return NOTE + head + "\n".join(rows) + "\n"


def ordered(name: str) -> tuple[int, str]:
    """Keep the order of the words, each with its own words after it."""
    return list(COMMANDS).index(name.split()[0]), name


def child_environment() -> dict[str, str]:
    """Fix what the help's layout depends on."""
    import os

    return {**os.environ, "COLUMNS": "100", "NO_COLOR": "1", "PYTHONPATH": str(ROOT / "src")}


def struct_section(shape: type[msgspec.Struct], level: str = "##", *, wire: bool = False) -> str:
    """Describe one struct: its sentence, then its fields; of a message also their limits."""
    doc = inspect.getdoc(shape) or ""
    head, _, attributes = doc.partition("Attributes:")
    notes = attribute_notes(attributes)
    info = msgspec.inspect.type_info(shape)
    if not isinstance(info, msgspec.inspect.StructType):
        raise TypeError(f"{shape} is not a struct")
    rows = [
        (
            f"`{field.encode_name}`",
            type_words(field.type),
            *((limits(field.type),) if wire else ()),
            "required" if field.required else default_words(field),
            meaning(shape, field.encode_name, notes) if wire else notes.get(field.encode_name, ""),
        )
        for field in info.fields
        if field.encode_name != FOREIGN_KEYS
    ]
    # A source's tag is never written: the device's connection says it.
    tagged = isinstance(info.tag, str) and not issubclass(shape, SourceShape)
    # Not in the heading: its anchor, which other rows link to, is the name alone.
    tag = f"Written as `{info.tag_field}: {info.tag}`.\n\n" if tagged else ""
    return f"{level} {shape.__name__}\n\n{tag}{head.strip()}\n\n" + table(
        ("field", "type", *(("limits",) if wire else ()), "default", "meaning"), rows
    )


def attribute_notes(text: str) -> dict[str, str]:
    """Read a docstring's ``Attributes:`` block: name to sentence."""
    flat = re.sub(r"\n\s{4,}(?=\S)", lambda m: "\n" if is_new(text, m.end()) else " ", "\n" + text)
    notes = {}
    for part in re.split(r"\n|(?<=\.)\s(?=[a-z_]+: )", flat):
        match = re.match(r"\s*([a-z_][a-z0-9_]*): (.*)", part)
        if match:
            notes[match[1]] = match[2].strip()
    return notes


def is_new(text: str, at: int) -> bool:
    """Tell whether an attribute's own line starts here."""
    return bool(re.match(r"[a-z_][a-z0-9_]*: ", text[at - 1 :]))


def type_words(kind: msgspec.inspect.Type) -> str:
    """Say a type in words that people of the field read."""
    match kind:
        case msgspec.inspect.EnumType() if kind.cls in ROLE_TABLES:
            return (
                f"one of the [{ROLE_TABLES[kind.cls]}](#{ROLE_TABLES[kind.cls].replace(' ', '-')})"
            )
        case msgspec.inspect.EnumType():
            return " or ".join(f"`{each.value}`" for each in kind.cls if isinstance(each, StrEnum))
        case msgspec.inspect.StructType():
            return f"[{kind.cls.__name__}](#{kind.cls.__name__.lower()})"
        case msgspec.inspect.UnionType():
            return " or ".join(type_words(each) for each in kind.types)
        case msgspec.inspect.DictType():
            return f"mapping of {type_words(kind.key_type)} to {type_words(kind.value_type)}"
        case msgspec.inspect.ListType() | msgspec.inspect.VarTupleType():
            return f"list of {type_words(kind.item_type)}"
        case msgspec.inspect.NoneType():
            return "none"
        case msgspec.inspect.StrType():
            return "text"
        case msgspec.inspect.IntType():
            return "whole number"
        case msgspec.inspect.FloatType():
            return "number"
        case msgspec.inspect.BoolType():
            return "true or false"
        case msgspec.inspect.BytesType():
            return "bytes"
        case _:
            return type(kind).__name__.removesuffix("Type").lower()


def default_words(field: msgspec.inspect.Field) -> str:
    """Say what an absent field means."""
    if field.default is msgspec.NODEFAULT:
        return "empty"
    if isinstance(field.default, bytes) or field.default == ():
        return "empty"
    if isinstance(field.default, msgspec.Struct):
        return "its defaults"
    if isinstance(field.default, StrEnum):
        return f"`{field.default.value}`"
    return "none" if field.default is None else f"`{json.dumps(field.default, ensure_ascii=False)}`"


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Write a Markdown table."""
    if not rows:
        return ""
    lines = [head, tuple("---" for _ in head), *rows]
    return (
        "\n".join(
            "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in lines
        )
        + "\n"
    )


if __name__ == "__main__":
    raise SystemExit(main(check_only="--check" in sys.argv))
