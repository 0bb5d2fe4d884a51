"""Run one of the tracker's networks: by OpenCV alone, or faster by LiteRT when it is installed.

OpenCV 5's default engine keeps only one output of a network, so the classic engine is used, which only works when
loading from a file path. OpenCV expects NCHW where the file has NHWC. With two threads the duration of networks this
small is erratic.
"""

import importlib.util
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.errors import ModelError

Backend = Literal["auto", "opencv", "litert"]
# From one input, images as (1, H, W, 3), to the outputs in the requested order.
InferenceFunction = Callable[[NDArray[np.float32]], list[NDArray[np.float32]]]


def load_network(path: Path, outputs: Sequence[str], /, *, backend: Backend = "auto") -> InferenceFunction:
    """Load a network file.

    outputs : names of the outputs
    backend : "auto" uses LiteRT when it is installed
    Raises ModelError if the file cannot be read or the backend is not installed.
    """
    if not path.is_file():
        raise ModelError(f"{path} is missing: run `conf models fetch`.")
    return (_load_with_litert if choose_backend(backend) == "litert" else _load_with_opencv)(path, outputs)


def choose_backend(backend: Backend, /) -> Literal["opencv", "litert"]:
    """Return the backend that "auto" means on this machine: LiteRT when the extra conf[fast] is installed."""
    if backend != "auto":
        return backend
    return "litert" if importlib.util.find_spec("ai_edge_litert") else "opencv"


def _load_with_opencv(path: Path, outputs: Sequence[str]) -> InferenceFunction:
    cv2.setNumThreads(1)
    classic = getattr(cv2.dnn, "ENGINE_CLASSIC", None)  # OpenCV 4 has no other engine
    engine = () if classic is None else (classic,)
    try:
        net = cv2.dnn.readNetFromTFLite(str(path), *engine)
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
    try:
        from ai_edge_litert.interpreter import Interpreter
    except ImportError as error:
        raise ModelError(
            "ai-edge-litert is not installed: pip install 'conf[fast]', or use the OpenCV backend."
        ) from error
    with _quiet_stderr():
        try:
            interpreter: Any = Interpreter(model_path=str(path), num_threads=1)
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
