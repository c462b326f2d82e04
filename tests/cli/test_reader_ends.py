"""A command whose reader has had enough, as `| head` does."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

NIGHT = Path(__file__).parents[2] / "bench" / "nights" / "hundred.json"


@pytest.mark.parametrize("words", [["docs"], ["schema"], ["plan", "night", "night.json"]])
def test_a_print_whose_reader_is_gone_ends_without_a_traceback(
    words: list[str], tmp_path: Path
) -> None:
    night = json.loads(NIGHT.read_bytes())
    night["requests"] = night["requests"][:3]
    (tmp_path / "night.json").write_text(json.dumps(night))
    with subprocess.Popen(
        [sys.executable, "-m", "talaia", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        said = process.stderr.read()
    assert (said, process.returncode) == (b"", 0)
