"""What a shell completes: commands, and the options that a command really has."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys

import pytest

from talaia.cli.examining.completion import main, option_words
from talaia.cli.main import COMMANDS


def test_commands_and_options_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--words"]) == 0
    assert capsys.readouterr().out.split() == list(COMMANDS)
    assert {"--port", "--log-format", "--show-settings"} <= set(option_words("hub", COMMANDS))
    assert {"--key-file", "--settings"} <= set(option_words("gateway", COMMANDS))
    assert option_words("no-command", COMMANDS) == []
    # Nothing was started, and words are read as before.
    assert argparse.ArgumentParser().parse_args([]) == argparse.Namespace()


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
        "              ['completion', '--words', 'hub'], ['completion', '--words', 'gateway']):\n"
        "    try: main(words)\n"
        "    except SystemExit: pass\n"
        "heavy = {'fastapi', 'sqlalchemy', 'numpy', 'uvicorn', 'websockets', 'asyncio', 'yaml'}\n"
        "print('imported:', sorted(heavy & sys.modules.keys()), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert "99999999 is not a port from 0 to 65535" in done.stderr
    assert done.stderr.splitlines()[-1] == "imported: []"
