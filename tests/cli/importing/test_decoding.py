"""Definitions that a recording of others carries: read as data, whatever they hold."""

from __future__ import annotations

import sys

import pytest

from talaia.cli.importing.decoding import Definition, Undecodable, decoder_of

pytestmark = pytest.mark.pure

# rosbags writes a class of this name and runs what it wrote.
SOURCE = "a/msg/B:\n    x: int\nimport sys\nsys.forged_type = True\nclass C"


@pytest.mark.parametrize("encoding", ["cdr", "ros1"])
def test_name_of_a_recorded_type_that_is_source_code_is_run_nowhere(encoding) -> None:
    with pytest.raises(Undecodable, match="no name of a type"):
        decoder_of(Definition(encoding, SOURCE, "msg", "float64 x"))
    assert not hasattr(sys, "forged_type")


def test_definition_that_is_none_is_named_and_one_of_ros_itself_is_known() -> None:
    with pytest.raises(Undecodable, match="cannot be read"):
        decoder_of(Definition("cdr", "a/msg/B", "idl", "=" * 80 + "\nIDL: a/msg/B"))
    read = decoder_of(Definition("cdr", "std_msgs/msg/Int8", "", ""))
    assert read(b"\0\1\0\0\xfb").data == -5
