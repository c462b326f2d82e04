"""Kinds of events are words of a closed list: the pages know each that hub and gateways write."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.pure

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "web/src/format/kinds/event-kinds.ts"
# Their first text is the kind.
WRITING = {
    "_append_record",
    "_make_event",
    "_record_event",
    "append_audit_record",
    "append_record",
    "record_event",
    "report_event",
}


CALLED = re.compile(rf"\b({'|'.join(sorted(WRITING))})\(")


def kinds_of(call: ast.Call) -> Iterator[str]:
    """Give the kinds that a call writes, as far as they stand there as they are."""
    for given in call.args[:3]:
        said = [given.body, given.orelse] if isinstance(given, ast.IfExp) else [given]
        texts = [one.value for one in said if isinstance(one, ast.Constant)]
        if texts:
            yield from (text.replace("_", " ") for text in texts if isinstance(text, str) and text)
            return
        if isinstance(given, ast.JoinedStr):
            return


def test_each_kind_of_event_that_is_written_has_words_in_the_pages_language() -> None:
    known = set(re.findall(r'^  "?([a-z][^":]*)"?: msg', PAGES.read_text(), re.MULTILINE))
    written: dict[str, str] = {}
    for path in (ROOT / "src/talaia").rglob("*.py"):
        text = path.read_text()
        # To parse all takes ten times as long.
        if not CALLED.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func).rsplit(".", 1)[-1]
                for kind in kinds_of(node) if name in WRITING else ():
                    written.setdefault(kind, f"{path.relative_to(ROOT)}:{node.lineno}")
    assert len(written) > 150
    assert {kind: where for kind, where in written.items() if kind not in known} == {}
