"""What detectors run on: names people write, and what ONNX Runtime says it has."""

import pytest

from talaia.objects.errors import DetectorError
from talaia.objects.providers import found_providers, parse_provider

pytestmark = pytest.mark.pure


def test_names_are_those_that_people_know() -> None:
    assert parse_provider("cuda").runtime_name == "CUDAExecutionProvider"
    assert parse_provider("cpu").on_processor
    assert parse_provider("openvino").on_processor
    assert not parse_provider("tensorrt").on_processor


def test_a_plug_in_is_a_name_and_its_library() -> None:
    choice = parse_provider("npu=/opt/npu/libep.so")
    assert (choice.name, choice.runtime_name, choice.library) == ("npu", "npu", "/opt/npu/libep.so")
    assert not choice.on_processor


@pytest.mark.parametrize("text", ["", "gpu", "CUDA", "=x", "npu="])
def test_what_is_none_is_refused_in_words(text) -> None:
    with pytest.raises(DetectorError, match=r"use one of|expected NAME=LIBRARY"):
        parse_provider(text)


def test_the_processor_is_the_last_and_nothing_sends_pictures_away() -> None:
    has = ["AzureExecutionProvider", "CPUExecutionProvider", "OpenVINOExecutionProvider"]
    assert found_providers(has) == ["openvino", "cpu"]
    assert found_providers(["CUDAExecutionProvider", "CPUExecutionProvider"]) == ["cuda", "cpu"]
