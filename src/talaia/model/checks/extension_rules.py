"""What installed extensions ask for in a description, and what is wrong with what it says. Pure.

The model loads no extension: whoever checks a description hands over what is installed there. A
hub hands over nothing, for it only shows what gateways do: keys that it does not know stay as
they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.checks.identifiers import Finding, id_fits
from talaia.model.connection import ExtensionConnection, ExtensionSource
from talaia.model.errors import UnknownWord
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    from talaia.model.connection import ExtensionScalar
    from talaia.model.site import Command, Device, Site

__all__ = [
    "NO_RULES",
    "AdapterRules",
    "ExtensionRules",
    "extension_findings",
    "keys_fit",
]


class AdapterRules(NamedTuple):
    """The keys that one adapter takes: of the connection, of a signal's source, of a command."""

    connection: type[msgspec.Struct]
    source: type[msgspec.Struct]
    command: type[msgspec.Struct] | None


class ExtensionRules(NamedTuple):
    """What is installed here, by name; what is not is not judged here.

    Attributes:
        adapters: keys of connections, signals and commands.
        detectors: keys of detectors.

    """

    adapters: Mapping[str, AdapterRules]
    detectors: Mapping[str, type[msgspec.Struct]]


# Nothing is installed here, or nobody asks: every key passes.
NO_RULES = ExtensionRules({}, {})


def extension_findings(site: Site, rules: ExtensionRules) -> Iterator[Finding]:
    """List what is wrong with the keys of connections, signals, commands and detectors."""
    links = site.links()
    for name, connection in links.items():
        if isinstance(connection, ExtensionConnection):
            yield from _check_connection(f"$.connections.{name}", connection, rules)
    for name, device in site.devices.items():
        where = f"$.devices.{name}"
        link = links.get(site.connection_of(name))
        if isinstance(link, ExtensionConnection):
            yield from _check_device(where, device, link, rules)
        for signal_id, signal in device.signals.items():
            for index, watch in enumerate(signal.anomalies):
                shape = rules.detectors.get(watch.extension)
                if shape is not None:
                    at = f"{where}.signals.{signal_id}.anomalies[{index}].keys"
                    yield from keys_fit(at, shape, watch.keys)


def _check_connection(
    where: str, link: ExtensionConnection, rules: ExtensionRules
) -> Iterator[Finding]:
    yield from id_fits(f"{where}.extension", link.extension)
    known = rules.adapters.get(link.extension)
    if known is not None:
        yield from keys_fit(f"{where}.keys", known.connection, link.keys)


def _check_device(
    where: str, device: Device, link: ExtensionConnection, rules: ExtensionRules
) -> Iterator[Finding]:
    known = rules.adapters.get(link.extension)
    for name, signal in device.signals.items():
        at = f"{where}.signals.{name}.source"
        if signal.type is SignalType.POSITION:
            problem = "an extension gives no positions"
            yield Finding(at, problem, "make a signal of each number")
        if known is not None and isinstance(signal.source, ExtensionSource):
            yield from keys_fit(f"{at}.keys", known.source, signal.source.keys)
    for name, command in device.commands.items():
        if known is not None:
            yield from _check_command(f"{where}.commands.{name}", command, link, known)


def _check_command(
    where: str, command: Command, link: ExtensionConnection, known: AdapterRules
) -> Iterator[Finding]:
    if known.command is None:
        problem = f"the extension {link.extension!r} knows no commands"
        yield Finding(where, problem, "leave it out")
        return
    # Arguments by the key that they fill; what they fill it with is not known yet.
    filled = {argument.field: name for name, argument in command.arguments.items()}
    given: dict[str, ExtensionScalar] = {"target": command.target, **command.fixed}
    for finding in keys_fit(f"{where}.fixed", known.command, given, filled):
        # Said where a person wrote it.
        at = f"{where}.target" if finding.where == f"{where}.fixed.target" else finding.where
        yield finding._replace(where=at)


def keys_fit(
    where: str,
    shape: type[msgspec.Struct],
    keys: Mapping[str, ExtensionScalar],
    filled: Mapping[str, str] | Collection[str] = (),
) -> Iterator[Finding]:
    """List what is wrong with an extension's keys.

    Args:
        where: the path of the keys.
        shape: what the extension asks for.
        keys: as they are written.
        filled: keys that are given later (arguments of a command).

    """
    fields = {field.encode_name: field for field in msgspec.structs.fields(shape)}
    for name in (*keys, *filled):
        if name not in fields:
            word = UnknownWord(f"{where}.{name}", "key", name, fields)
            yield Finding(word.where, word.problem, word.remedy)
    # Judged as a whole only with every key there, and each one right.
    whole = not filled
    for name, field in fields.items():
        if name in keys:
            # One by one, so that each mistake is named at its own key.
            try:
                msgspec.convert(keys[name], field.type)
            except msgspec.ValidationError as error:
                whole = False
                yield Finding(f"{where}.{name}", _plain_sentence(str(error)))
        elif field.required and name not in filled:
            whole = False
            yield Finding(f"{where}.{name}", "it is missing", f"write: {name}: …")
    if not whole or any(name not in fields for name in keys):
        return
    try:
        # What fits together only as a whole: what a shape's own `__post_init__` says.
        msgspec.convert(dict(keys), shape)
    except msgspec.ValidationError as error:
        yield Finding(where, _plain_sentence(str(error)))


def _plain_sentence(said: str) -> str:
    return said[:1].lower() + said[1:].replace("`", "")
