"""ONNX Runtime's execution providers: what a detector may run on beside the processor. Pure.

Which of them a machine has depends on the package that brings ONNX Runtime there: `onnxruntime`
has the processor alone, `onnxruntime-gpu` and `onnxruntime-openvino` bring others, and a vendor's
plug-in is a library of its own (https://onnxruntime.ai/docs/execution-providers).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.objects.errors import DetectorError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["CPU", "ProviderChoice", "found_providers", "parse_provider"]

CPU = "cpu"
# What people write, and what ONNX Runtime calls it. Those that send pictures to another machine
# (Azure's) are left out on purpose.
_NAMES = {
    "tensorrt": "TensorrtExecutionProvider",
    "cuda": "CUDAExecutionProvider",
    "rocm": "ROCMExecutionProvider",
    "migraphx": "MIGraphXExecutionProvider",
    "hailo": "HailoExecutionProvider",
    "qnn": "QNNExecutionProvider",
    "openvino": "OpenVINOExecutionProvider",
    "coreml": "CoreMLExecutionProvider",
    CPU: "CPUExecutionProvider",
}


class ProviderChoice(NamedTuple):
    """What a detector is to run on.

    Attributes:
        name: as people write it.
        runtime_name: as ONNX Runtime calls it.
        library: file of a vendor's plug-in; empty for what ONNX Runtime brings itself.

    """

    name: str
    runtime_name: str
    library: str = ""

    @property
    def on_processor(self) -> bool:
        """Tell whether the processor's own memory and cores are all that it takes."""
        return self.name in (CPU, "openvino")


def parse_provider(text: str) -> ProviderChoice:
    """Read what a person wrote: a name, or ``NAME=LIBRARY`` of a plug-in.

    Raises:
        DetectorError: there is none of that name.

    """
    name, equals, library = text.partition("=")
    if equals:
        if not name or not library:
            raise DetectorError(f"{text!r}: expected NAME=LIBRARY, as in npu=/opt/npu/libep.so")
        return ProviderChoice(name, name, library)
    if name not in _NAMES:
        raise DetectorError(
            f"{text!r} is nothing that a detector runs on; use one of {', '.join(sorted(_NAMES))}, "
            "or NAME=LIBRARY of a plug-in"
        )
    return ProviderChoice(name, _NAMES[name])


def found_providers(available: Sequence[str]) -> list[str]:
    """Name those that an ONNX Runtime says it has, the processor last."""
    return [name for name, runtime_name in _NAMES.items() if runtime_name in available]
