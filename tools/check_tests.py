"""Hold what tests should hardly do at its number of today: replace parts, wait for a fixed time.

    .venv/bin/python tools/check_tests.py

A *replaced part* is a ``monkeypatch.setattr`` or something of `unittest.mock`. A *fixed wait* is a
``sleep`` that is in no loop: it waits for time and not for a condition. Both numbers only ever go
down: who brings one down writes the new one here.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).resolve().parent.parent
MOST = {"replaced parts": 99, "fixed waits": 38}
MOCKS = {"Mock", "MagicMock", "AsyncMock", "patch", "create_autospec"}


def name_of(call: ast.Call) -> str:
    """Give the last word of what is called."""
    match call.func:
        case ast.Attribute(attr=name) | ast.Name(id=name):
            return name
    return ""


def is_replacement(call: ast.Call) -> bool:
    """Tell whether a call replaces a part of the program."""
    match call.func:
        case ast.Attribute(value=ast.Name(id="monkeypatch"), attr="setattr" | "setitem"):
            return True
    return name_of(call) in MOCKS


def is_wait(call: ast.Call) -> bool:
    """Tell whether a call waits for some time: ``sleep(0)`` only lets others have their turn."""
    if name_of(call) != "sleep" or not call.args:
        return False
    match call.args[0]:
        case ast.Constant(value=0):
            return False
    return True


def find(node: ast.AST, *, in_loop: bool = False) -> Iterator[tuple[int, str]]:
    """Find lines below ``node`` that count, and as what."""
    for child in ast.iter_child_nodes(node):
        inside = in_loop
        if isinstance(child, ast.While | ast.For | ast.AsyncFor):
            inside = True
        elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            inside = False
        if isinstance(child, ast.Call):
            if is_replacement(child):
                yield child.lineno, "replaced parts"
            elif is_wait(child) and not in_loop:
                yield child.lineno, "fixed waits"
        yield from find(child, in_loop=inside)


def main() -> int:
    """Print each place of what is too often there; 1 when something is."""
    found: dict[str, list[str]] = {kind: [] for kind in MOST}
    tests = 0
    for path in sorted((ROOT / "tests").rglob("*.py")):
        tree = ast.parse(path.read_text())
        functions = (ast.FunctionDef, ast.AsyncFunctionDef)
        tests += sum(
            isinstance(node, functions) and node.name.startswith("test_") for node in ast.walk(tree)
        )
        for line, kind in find(tree):
            found[kind].append(f"{path.relative_to(ROOT).as_posix()}:{line}")
    wrong = 0
    for kind, places in found.items():
        print(f"{len(places)} {kind} in {tests} tests; at most {MOST[kind]}")
        if len(places) > MOST[kind]:
            wrong = 1
            print("\n".join(places))
        elif len(places) < MOST[kind]:
            print(f"Write {len(places)} into tools/check_tests.py, so that it stays at that.")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
