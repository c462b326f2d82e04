"""What detectors can run on is tried, in a process each, and told as it is."""

import sys
from pathlib import Path

import pytest

from talaia.objects.provider_trial import try_providers

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "gateway"))
from detector_files import require_own, require_runtime


def test_the_processor_is_tried_with_a_picture() -> None:
    require_runtime()
    require_own()
    trials = {trial.name: trial for trial in try_providers()}
    assert trials["cpu"].problem == ""
    assert 0 < trials["cpu"].picture_s < 60
    assert "azure" not in trials


def test_a_runtime_that_cannot_be_loaded_or_crashes_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "onnxruntime.py"
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{Path(__file__).resolve().parents[2] / 'src'}")
    package.write_text("raise ImportError('libcudart.so.12 is missing')\n")
    (trial,) = try_providers()
    assert trial.problem == "libcudart.so.12 is missing"
    package.write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    (trial,) = try_providers()
    assert trial.problem == "its process ended by signal 11"
    # Lists a device that it then does not have.
    package.write_text(
        "def get_available_providers():\n    return ['CUDAExecutionProvider']\n"
        "def set_default_logger_severity(_):\n    pass\n"
        "class SessionOptions:\n    def add_session_config_entry(self, *_):\n        pass\n"
        "class InferenceSession:\n    def __init__(self, *_, **__):\n        pass\n"
        "    def get_providers(self):\n        return ['CPUExecutionProvider']\n"
    )
    (trial,) = try_providers()
    assert trial.name == "cuda"
    assert trial.problem == "cuda cannot be used; its driver or library is missing"
