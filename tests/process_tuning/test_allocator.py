"""A process that reads a lot now and then gives the memory back."""

import platform
import subprocess
import sys

import pytest

# Once a lot is read; then half as much, and a little after it that is kept.
WORK = """
import ctypes, sys
from talaia.process_tuning.allocator import keep_little_free_memory
if sys.argv[1] == "set":
    assert keep_little_free_memory()
bytearray(20_000_000)
read = bytearray(10_000_000)
kept = [bytearray(100_000) for _ in range(10)]
del read
names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost".split()
class Found(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in names]
libc = ctypes.CDLL(None)
libc.mallinfo2.restype = Found
print(libc.mallinfo2().fordblks)
"""


# Pieces as raw topics of a megabyte need them, again and again: how many pages are mapped for them.
PIECES = """
import resource
from talaia.process_tuning.allocator import keep_little_free_memory
assert keep_little_free_memory()
def pass_on():
    for _ in range(20):
        copies = [bytes(1_000_000) for _ in range(3)]
        assert copies
pass_on()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
pass_on()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def free_after(mode: str) -> int:
    """Give what the C library holds that nobody uses (bytes)."""
    done = subprocess.run(
        [sys.executable, "-c", WORK, mode], capture_output=True, text=True, check=True
    )
    return int(done.stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library")
def test_what_was_read_is_given_back_though_something_after_it_is_kept() -> None:
    assert free_after("set") < 2_000_000
    assert free_after("not set") > 9_000_000


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library")
def test_pieces_of_a_megabyte_are_not_mapped_anew_each_time() -> None:
    done = subprocess.run(
        [sys.executable, "-c", PIECES], capture_output=True, text=True, check=True
    )
    # Sixty pieces of 244 pages each.
    assert int(done.stdout) < 1_000
