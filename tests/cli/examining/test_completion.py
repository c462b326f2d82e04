"""What a shell completes: commands, and the options that a command really has."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys

import pytest

from talaia.cli.examining.completion import main, words_at
from talaia.cli.main import COMMANDS


def test_commands_and_options_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--words", ""]) == 0
    assert capsys.readouterr().out.split() == list(COMMANDS)
    assert words_at(["sup"], COMMANDS) == ["support-bundle"]
    assert {"--port", "--log-format", "--show-settings"} <= set(words_at(["hub", "-"], COMMANDS))
    assert words_at(["gateway", "site.yaml", "--key-f"], COMMANDS) == ["--key-file"]
    assert words_at(["no-command", "-"], COMMANDS) == []
    # Nothing was started, and words are read as before.
    assert argparse.ArgumentParser().parse_args([]) == argparse.Namespace()


def test_words_of_a_command_its_options_and_their_choices_are_listed() -> None:
    assert words_at(["record", ""], COMMANDS) == ["start", "stop", "list", "fetch"]
    assert "--camera" in words_at(["record", "start", "--"], COMMANDS)
    assert "--camera" not in words_at(["record", "list", "--"], COMMANDS)
    assert words_at(["hub", "--log-level", ""], COMMANDS) == ["debug", "info", "warning", "error"]
    # A file stands here, and the shell knows those.
    assert words_at(["check", ""], COMMANDS) == []
    assert words_at(["hub", "--data", ""], COMMANDS) == []
    # The site is called as a word is.
    assert words_at(["record", "list", "--token-file", "list", "-"], COMMANDS)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_script_is_one_that_its_shell_reads(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([shell]) == 0
    script = capsys.readouterr().out
    assert "talaia completion --words" in script
    # bash is everywhere; the others read theirs where they are installed.
    if shutil.which(shell) is not None:
        subprocess.run([shell, "-n"], input=script, text=True, check=True)


def test_help_and_wrong_words_import_nothing_of_the_programs() -> None:
    probe = (
        "import sys; from talaia.cli.main import main\n"
        "for words in (['hub', '--help'], ['hub', '--port', '99999999'], ['gateway', '--help'],\n"
        "              ['completion', '--words', 'hub', '-'],\n"
        "              ['completion', '--words', 'gateway', '-']):\n"
        "    try: main(words)\n"
        "    except SystemExit: pass\n"
        "heavy = {'fastapi', 'sqlalchemy', 'numpy', 'uvicorn', 'websockets', 'asyncio', 'yaml'}\n"
        "print('imported:', sorted(heavy & sys.modules.keys()), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert "99999999 is not a port from 0 to 65535" in done.stderr
    assert done.stderr.splitlines()[-1] == "imported: []"
