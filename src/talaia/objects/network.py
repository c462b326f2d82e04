"""A network in an ONNX file, opened on what it is to run on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from talaia.objects.errors import DetectorError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from talaia.objects.providers import ProviderChoice

__all__ = ["error_text", "open_network"]


def open_network(
    file: str, provider: ProviderChoice
) -> Callable[[NDArray[np.float32]], Sequence[NDArray[np.float32]]]:
    """Load a file; the function that is given runs it.

    Raises:
        DetectorError: it cannot be loaded, or not on that; the function raises it when it cannot
            be run.

    """
    try:
        # Here, not at the top: without it the answer must still be a sentence.
        import onnxruntime
    except ImportError as error:
        raise DetectorError(f"{error}; install talaia[objects]") from error
    # 3 is errors: its warnings about a file's graph are of no use to who drives.
    onnxruntime.set_default_logger_severity(3)
    options = onnxruntime.SessionOptions()
    # One thread, which sleeps between pictures instead of spinning: the other cores are the
    # robot's.
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    try:
        session = _open_session(onnxruntime, file, options, provider)
    except DetectorError:
        raise
    except Exception as error:
        raise DetectorError(f"{file} cannot be loaded: {error_text(error)}") from error
    inputs = session.get_inputs()
    if len(inputs) != 1:
        raise DetectorError(f"{file} wants {len(inputs)} inputs; expected one, a picture")
    name, wants = inputs[0].name, inputs[0].shape
    if inputs[0].type != "tensor(float)":
        raise DetectorError(
            f"{file} wants {inputs[0].type}; expected a picture of 32-bit floats, tensor(float)"
        )

    def run(shown: NDArray[np.float32]) -> Sequence[NDArray[np.float32]]:
        if not _fits(wants, shown.shape):
            raise DetectorError(
                f"{file} cannot be run: it wants {_shape_text(wants)}, and is shown "
                f"{_shape_text(shown.shape)}; correct its side, or export it for such pictures"
            )
        try:
            found: Sequence[NDArray[np.float32]] = session.run(None, {name: shown})
        except Exception as error:
            raise DetectorError(f"{file} cannot be run: {error_text(error)}") from error
        return found

    return run


def _fits(wants: Sequence[object], shape: Sequence[int]) -> bool:
    # What is no number may be of any size; of an input without a shape nothing is known.
    if not wants:
        return True
    pairs = zip(wants, shape, strict=False)
    return len(wants) == len(shape) and all(
        not isinstance(size, int) or size == own for size, own in pairs
    )


def _shape_text(shape: Sequence[object]) -> str:
    return " × ".join(str(size) if isinstance(size, int) else "any" for size in shape)


def _open_session(
    library: Any,  # noqa: ANN401 - a module that may not be there
    file: str,
    options: Any,  # noqa: ANN401 - of that module
    provider: ProviderChoice,
) -> Any:  # noqa: ANN401 - of that module
    if provider.library:
        library.register_execution_provider_library(provider.name, provider.library)
        devices = [device for device in library.get_ep_devices() if device.ep_name == provider.name]
        if not devices:
            raise DetectorError(f"{provider.library} finds no device of {provider.name} here")
        options.add_provider_for_devices(devices[:1], {})
        return library.InferenceSession(file, options)
    if provider.runtime_name not in library.get_available_providers():
        raise DetectorError(
            f"this ONNX Runtime has no {provider.name}; it has "
            f"{', '.join(library.get_available_providers())}"
        )
    own = {"num_of_threads": "1"} if provider.name == "openvino" else {}
    session = library.InferenceSession(file, options, providers=[(provider.runtime_name, own)])
    # Where a device's library cannot be loaded the processor is taken without a word.
    if provider.runtime_name not in session.get_providers():
        raise DetectorError(f"{provider.name} cannot be used; its driver or library is missing")
    return session


def error_text(error: BaseException) -> str:
    """Give an error in one line; a library's message may be pages long."""
    said = " ".join(str(error).split())[:1000]
    return said if isinstance(error, DetectorError) else f"{type(error).__name__}: {said}"
