"""``talaia plan night`` whose reader has had enough, as `| head` does."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

NIGHT = Path(__file__).parents[3] / "bench" / "nights" / "hundred.json"


def test_a_print_whose_reader_is_gone_ends_without_a_traceback(tmp_path: Path) -> None:
    night = json.loads(NIGHT.read_bytes())
    night["requests"] = night["requests"][:3]
    (tmp_path / "night.json").write_text(json.dumps(night))
    command = [sys.executable, "-m", "talaia", "plan", "night", str(tmp_path / "night.json")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        said = process.stderr.read()
    assert (said, process.returncode) == (b"", 0)
