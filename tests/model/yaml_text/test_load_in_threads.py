"""Descriptions may be read by several threads at once, from the first one on."""

import subprocess
import sys
from pathlib import Path

import talaia

SOURCE = Path(talaia.__file__).resolve().parent.parent
# In a process of its own: only the first reading of a process was dangerous.
READ_AT_ONCE = """
import sys, threading
from pathlib import Path
from talaia.model.yaml_text.load import load_site
sys.setswitchinterval(1e-6)
text = Path(sys.argv[1]).read_text()
barrier = threading.Barrier(4)
def read():
    barrier.wait()
    load_site(text)
threads = [threading.Thread(target=read) for _ in range(4)]
for each in threads: each.start()
for each in threads: each.join()
"""


def test_threads_that_read_the_first_description_at_once_do_not_end_the_process() -> None:
    example = Path(__file__).parents[3] / "examples" / "agv" / "site.yaml"
    for _ in range(3):
        done = subprocess.run(
            [sys.executable, "-c", READ_AT_ONCE, str(example)],
            env={"PYTHONPATH": str(SOURCE)},
            capture_output=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr.decode()
