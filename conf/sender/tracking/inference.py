"""Run one of the tracker's networks: by LiteRT, or by OpenCV where LiteRT has no wheel or cannot be imported.

OpenCV 5's default engine keeps only one output of a network, so the classic engine is used, which only works when
loading from a file path. OpenCV expects NCHW where the file has NHWC. With two threads the duration of networks this
small is erratic, with either backend.
"""

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import ModelError

Backend = Literal["auto", "opencv", "litert"]
# What importing LiteRT raises: ImportError when it or a library is missing, the others when NumPy, ml_dtypes or its
# own native part are of a version that does not fit.
_IMPORT_ERRORS = (ImportError, OSError, AttributeError, TypeError, ValueError, RuntimeError)
# From one input, images as (1, H, W, 3), to the outputs in the requested order.
InferenceFunction = Callable[[NDArray[np.float32]], list[NDArray[np.float32]]]


def load_network(path: Path, outputs: Sequence[str], /, *, backend: Backend = "auto") -> InferenceFunction:
    """Load a network file.

    outputs : names of the outputs
    backend : "auto" uses LiteRT when it can be imported
    Raises ModelError if the file cannot be read or the backend cannot be imported.
    """
    if not path.is_file():
        raise ModelError(f"{path} is missing: run `conf models fetch`.")
    return (_load_with_litert if choose_backend(backend) == "litert" else _load_with_opencv)(path, outputs)


def choose_backend(backend: Backend, /) -> Literal["opencv", "litert"]:
    """Return the backend that "auto" means on this machine: LiteRT when it can be imported, else OpenCV."""
    if backend != "auto":
        return backend
    try:
        _import_litert()
    except ModelError:
        return "opencv"
    return "litert"


def describe_backend() -> str:
    """Return name and version of the backend that "auto" means here, and why it is not LiteRT."""
    try:
        _import_litert()
    except ModelError as error:
        return f"OpenCV {cv2.__version__} ({error})"
    from importlib.metadata import PackageNotFoundError, version  # slow, and only `conf doctor` calls this

    try:
        return f"LiteRT {version('ai-edge-litert')}"
    except PackageNotFoundError:  # imported from a folder without metadata
        return "LiteRT"


def _import_litert() -> Any:
    """Return LiteRT's interpreter class. Raises ModelError if it cannot be imported."""
    try:
        from ai_edge_litert.interpreter import Interpreter
    except ModuleNotFoundError as error:
        raise ModelError("ai-edge-litert is not installed: pip install ai-edge-litert, where it has a wheel") from error
    except _IMPORT_ERRORS as error:
        raise ModelError(
            f"ai-edge-litert cannot be imported, {error}: pip install --force-reinstall ai-edge-litert"
        ) from error
    return Interpreter


@contextmanager
def _utf8_named(path: Path) -> Iterator[Path]:
    """Yield a file of the same content whose name OpenCV can bear: one that is not UTF-8 would end the process."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        with tempfile.TemporaryDirectory() as folder:
            yield Path(shutil.copy(path, Path(folder) / "model.tflite"))
    else:
        yield path


def _load_with_opencv(path: Path, outputs: Sequence[str]) -> InferenceFunction:
    cv2.setNumThreads(1)
    classic = getattr(cv2.dnn, "ENGINE_CLASSIC", None)  # OpenCV 4 has no other engine
    engine = () if classic is None else (classic,)
    try:
        with _utf8_named(path) as readable:
            net = cv2.dnn.readNetFromTFLite(str(readable), *engine)
        net.enableFusion(False)  # same outputs, 0.7 ms faster: fused layers use a slower convolution
    except cv2.error as error:
        raise ModelError(f"{path} is damaged: run `conf models fetch` to get it again.") from error
    names = list(outputs)

    def run(values: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        net.setInput(values.transpose(0, 3, 1, 2).copy() if values.ndim == 4 else values)
        # copied: OpenCV returns views of memory that the next run overwrites
        return [np.array(output, dtype=np.float32) for output in net.forward(names)]

    return run


def _load_with_litert(path: Path, outputs: Sequence[str]) -> InferenceFunction:
    interpreter_class = _import_litert()
    with _quiet_stderr():
        try:
            interpreter = interpreter_class(model_content=path.read_bytes(), num_threads=1)
            interpreter.allocate_tensors()
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"{path} is damaged: run `conf models fetch` to get it again.") from error
    [source] = (detail["index"] for detail in interpreter.get_input_details())
    by_name = {detail["name"]: detail["index"] for detail in interpreter.get_output_details()}
    targets = [by_name[name] for name in outputs]

    def run(values: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        interpreter.set_tensor(source, values)
        interpreter.invoke()
        return [interpreter.get_tensor(target) for target in targets]

    return run


@contextmanager
def _quiet_stderr() -> Iterator[None]:
    """Keep LiteRT's banner, which C++ writes past Python's streams, off the user's terminal."""
    kept = os.dup(2)
    silent = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(silent, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(silent)
        os.close(kept)
