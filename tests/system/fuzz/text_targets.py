"""Readers of what people and other programs write: descriptions, conditions, lists of requests."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from talaia.gateway.adapters.json_signals import parse_payload
from talaia.gateway.errors import FieldError
from talaia.gateway.legacy.messages import LegacyRequestError, read_message as read_legacy
from talaia.gateway.samples.field_paths import parse_path
from talaia.hub.request_files.imported import ImportDefaults, Misread
from talaia.hub.request_files.readers import FileKind, read_request_file
from talaia.model.alarms.expression import ExpressionError, ValueKind, parse_expression
from talaia.model.checks.site_checks import check_site
from talaia.model.connections.json_path import parse_json_path
from talaia.model.discovery.command_file import read_classic
from talaia.model.errors import DescriptionError
from talaia.model.list_texts import LIST_TYPES, parse_list
from talaia.model.observing.requests import Window
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.model.yaml_text.upgrade import upgrade_text

from .target import FuzzTarget

_KINDS = {
    "base/speed": ValueKind.NUMBER,
    "base/mode": ValueKind.TEXT,
    "base/open": ValueKind.NUMBER,
}
_VALUES = ({}, {"base/speed": 1.5, "base/mode": "on", "base/open": 0.0}, {"base/speed": 1e308})
_DEFAULTS = ImportDefaults("p", Window(start=1.7e9, end=1.8e9))
# Its commands are programs, as those of the founding observatory.
_SITE = load_site((Path(__file__).parents[3] / "examples/observatory/site.yaml").read_text())


def _read_description(data: bytes) -> None:
    site = load_site(data.decode("utf-8", "replace"))
    findings = check_site(site)
    for finding in findings:
        str(finding)
    # Whatever was understood is written and read back as it was.
    assert load_site(dump_site(site)) == site


def _upgrade(data: bytes) -> None:
    upgrade_text(data.decode("utf-8", "replace"))


def _read_commands(data: bytes) -> None:
    read_classic(data.decode("utf-8", "replace"))


def _read_expression(data: bytes) -> None:
    found = parse_expression(data.decode("utf-8", "replace"), _KINDS)
    for values in _VALUES:
        found.evaluate_value(values)
        found.evaluate_expression(values)


def _read_paths(data: bytes) -> None:
    text = data.decode("utf-8", "replace")
    for kind in LIST_TYPES:
        parse_list(kind, text)
    for read in (parse_json_path, parse_path):
        try:
            read(text)
        except (DescriptionError, FieldError):
            continue


def _read_requests(kind: FileKind, data: bytes) -> None:
    read_request_file(kind, data.decode("utf-8", "replace"), _DEFAULTS)


TARGETS = (
    FuzzTarget("description", _read_description, (DescriptionError,), share=0.3),
    FuzzTarget("upgrade", _upgrade, (DescriptionError,), share=0.2),
    FuzzTarget(
        "command_file",
        lambda data: read_classic(data.decode("utf-8", "replace")),
        (DescriptionError,),
    ),
    FuzzTarget("expression", _read_expression, (ExpressionError,)),
    FuzzTarget("paths", _read_paths, ()),
    FuzzTarget("payload", parse_payload, (FieldError,)),
    FuzzTarget("founding_door", lambda data: read_legacy(data, _SITE), (LegacyRequestError,)),
    *(
        FuzzTarget(f"requests_{kind}", partial(_read_requests, kind), (Misread,))
        for kind in FileKind
    ),
)
