"""What our own code must never hold, read from the code: SQL made of text, shells, code in data."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest
import yaml

import talaia
from talaia.model.checks.site_checks import raise_first
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import load_site

SOURCE = Path(talaia.__file__).parent
# Calls that turn text into code, or bytes into objects.
CODE = {"eval", "exec", "compile", "__import__"}
MODULES_OF_CODE = {"pickle", "marshal", "shelve", "dill", "jinja2", "mako"}
# What speaks to addresses that somebody else chose.
CLIENTS = {"httpx", "requests", "aiohttp", "urllib.request", "urllib3", "http.client", "ftplib"}
CLIENTS |= {"smtplib", "apprise"}
# Names of our own tables and pragmas, written in the very file: no word of anybody else's.
OUR_WORDS = {
    # Beside our names only numbers and bytes in hex; `_literal` refuses anything else.
    "hub/store/dialects",
    "hub/store/history_tables.py",
    "hub/store/migrations",
    # Names of a file's own tables, quoted; the file is only looked at.
    "hub/store/quarantine.py",
}
# Take a text for SQL as it stands.
SQL = {"text", "exec_driver_sql", "execute", "executemany", "executescript"}


@cache
def trees() -> dict[Path, ast.Module]:
    return {path: ast.parse(path.read_text()) for path in SOURCE.rglob("*.py")}


def calls(*names: str) -> list[tuple[Path, ast.Call]]:
    """List the calls of functions and methods by their last name."""
    return [
        (path, node)
        for path, tree in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and _name(node.func) in names
    ]


def _name(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else getattr(node, "attr", "")


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(trees()[path]):
        if isinstance(node, ast.Import):
            found |= {each.name for each in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
    return found


def places(found: list[tuple[Path, ast.AST]]) -> list[str]:
    return [f"{path.relative_to(SOURCE)}:{getattr(node, 'lineno', 0)}" for path, node in found]


def _is_made(text: ast.expr) -> bool:
    """Tell whether a text is put together from parts."""
    if isinstance(text, ast.JoinedStr):
        return any(isinstance(each, ast.FormattedValue) for each in text.values)
    if isinstance(text, ast.BinOp):
        return isinstance(text.op, ast.Mod | ast.Add)
    return isinstance(text, ast.Call) and _name(text.func) in {"format", "join", "replace"}


def test_the_search_finds_what_it_looks_for() -> None:
    made = ast.parse('run(f"select {a}"); run("a" + b); run("%s" % c); run("{}".format(d))')
    arguments = [
        node.args[0] for node in ast.walk(made) if isinstance(node, ast.Call) and node.args
    ]
    assert sum(map(_is_made, arguments)) == 4
    assert len(trees()) > 100
    assert calls("create_task")


def test_no_sql_is_put_together_from_text() -> None:
    wrong = [
        (path, call)
        for path, call in calls(*SQL)
        if path.is_relative_to(SOURCE / "hub")
        and not any(path.is_relative_to(SOURCE / ours) for ours in OUR_WORDS)
        and call.args
        and _is_made(call.args[0])
    ]
    assert places(wrong) == []


def test_no_text_becomes_code_and_no_bytes_become_objects() -> None:
    called = [(path, call) for path, call in calls(*CODE) if isinstance(call.func, ast.Name)]
    assert places(called) == []
    assert [str(path) for path in trees() if imports(path) & MODULES_OF_CODE] == []


def test_no_shell_is_ever_asked() -> None:
    shells = [
        (path, call)
        for path, call in calls(
            "run", "Popen", "call", "check_output", "create_subprocess_exec", "system", "popen"
        )
        if any(each.arg == "shell" for each in call.keywords)
        or _name(call.func) in {"system", "popen"}
    ]
    assert places([*shells, *calls("create_subprocess_shell", "getoutput")]) == []


def test_the_hub_calls_no_address_that_it_is_given() -> None:
    wrong = [path for path in trees() if path.is_relative_to(SOURCE / "hub")]
    # But for the process that sends one message: whatever asks there, `socket.getaddrinfo` itself
    # gives it no address that messages may not go to; see `tests/hub/notify/test_senders.py`.
    child = SOURCE / "hub" / "notify" / "child.py"
    # And for the one provider of sign-ins that the administrator's own file names.
    provider = SOURCE / "hub" / "auth" / "provider_client.py"
    # And for Google's one host, where an admin has allowed its map; by the provider's own client.
    google = SOURCE / "hub" / "api" / "maps" / "google_sessions.py"
    assert {path for path in wrong if imports(path) & CLIENTS} == {child, provider, google}


def test_yaml_is_read_by_the_safe_loader_only() -> None:
    unsafe = calls("unsafe_load", "full_load", "load_all", "UnsafeLoader", "FullLoader")
    assert places(unsafe) == []


@pytest.mark.parametrize(
    "hostile",
    [
        "!!python/object/apply:os.system ['touch {proof}']",
        "talaia: !!python/object/apply:subprocess.check_output [[touch, '{proof}']]",
        "!!python/object/new:type {{args: [z, [], {{}}]}}",
        "!!python/name:os.system",
        "!!python/module:os",
    ],
)
def test_yaml_that_names_python_objects_runs_nothing(hostile, tmp_path) -> None:
    proof = tmp_path / "proof"
    written = hostile.format(proof=proof)
    with pytest.raises(DescriptionError):
        load_site(written)
    assert not proof.exists()
    # The text is a real danger: a loader that allows it would have made the object.
    if "apply" in hostile:
        yaml.unsafe_load(written)
        assert proof.exists()


@pytest.mark.parametrize(
    "name",
    [
        "a b",
        "$(reboot)",
        "`id`",
        "a;b",
        "a|b",
        "../a",
        "a/b",
        "A",
        "-rf",
        "a\nb",
        "é",
        "",
        "a" * 99,
    ],
)
@pytest.mark.parametrize("place", ["site: {name}", "devices: {{{name}: {{name: X}}}}"])
def test_names_that_reach_files_and_commands_are_of_a_narrow_alphabet(name, place) -> None:
    quoted = yaml.safe_dump(name).partition("\n...")[0].strip()
    head = "talaia: 1\nname: X\nros2: {}\n"
    rest = "" if place.startswith("site") else "site: agv\n"
    with pytest.raises(DescriptionError):
        raise_first(load_site(head + rest + place.format(name=quoted)))
