import builtins
import os
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from packaging.requirements import Requirement

from conf.errors import ModelError
from conf.sender.capture.clip import open_clip
from conf.sender.tracking.inference import Backend, choose_backend, describe_backend, load_network
from conf.sender.tracking.model_files import BLENDSHAPES, DETECTOR, LANDMARKS
from conf.sender.tracking.tracker import FaceTracker

has_litert = choose_backend("auto") == "litert"
needs_litert = pytest.mark.skipif(not has_litert, reason="ai-edge-litert has no wheel for this machine")
BACKENDS: list[Backend] = ["opencv", "litert"] if has_litert else ["opencv"]

NETWORKS = [
    (DETECTOR, (1, 128, 128, 3), ("regressors", "classificators"), 1e-3),
    (LANDMARKS, (1, 256, 256, 3), ("Identity", "Identity_1"), 1e-2),
    (BLENDSHAPES, (1, 146, 2), ("StatefulPartitionedCall:0",), 1e-4),
]


@pytest.mark.slow
@needs_litert
@pytest.mark.parametrize(("name", "shape", "outputs", "tolerance"), NETWORKS, ids=lambda v: str(v)[:20])
def test_both_backends_give_the_same_outputs(
    models: Path, name: str, shape: tuple[int, ...], outputs: tuple[str, ...], tolerance: float
) -> None:
    values = np.random.default_rng(1).random(shape, dtype=np.float32) * (200 if len(shape) == 3 else 1)
    by_opencv = load_network(models / name, outputs, backend="opencv")(values)
    by_litert = load_network(models / name, outputs, backend="litert")(values)
    assert len(by_opencv) == len(by_litert) == len(outputs)
    for a, b in zip(by_opencv, by_litert, strict=True):
        assert np.allclose(a.ravel(), b.ravel(), atol=tolerance)


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_output_is_not_overwritten_by_the_next_run(models: Path, backend: Backend) -> None:
    run = load_network(models / BLENDSHAPES, ("StatefulPartitionedCall:0",), backend=backend)
    values = np.random.default_rng(1).random((1, 146, 2), dtype=np.float32) * 200
    [first] = run(values)
    kept = first.copy()
    run(values * np.float32(0.5) + np.float32(30) * values[:, ::-1])
    assert np.array_equal(first, kept)


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_message_for_a_missing_or_damaged_file_names_the_remedy(tmp_path: Path, backend: Backend) -> None:
    path = tmp_path / "net.tflite"
    with pytest.raises(ModelError) as missing:
        load_network(path, ("out",), backend=backend)
    assert str(missing.value) == f"{path} is missing: run `conf models fetch`."
    path.write_bytes(b"TFL3 but not really" * 10)
    with pytest.raises(ModelError) as damaged:
        load_network(path, ("out",), backend=backend)
    assert str(damaged.value) == f"{path} is damaged: run `conf models fetch` to get it again."


def largest_difference(models: Path, images: list[NDArray[np.uint8]]) -> float:
    """Return how far apart the backends place a landmark in a clip, px of the image, each following its own crops."""
    by_opencv, by_litert = FaceTracker(models, backend="opencv"), FaceTracker(models, backend="litert")
    largest = 0.0
    for pixels in images:
        a, b = by_opencv.track(pixels), by_litert.track(pixels)
        assert a is not None and b is not None
        largest = max(largest, float(np.abs(a.landmarks - b.landmarks)[:, :2].max()))
    return largest


@needs_litert
@pytest.mark.slow
def test_both_backends_track_the_same_landmarks(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    assert largest_difference(models, carphone) < 0.3


@needs_litert
@pytest.mark.slow
@pytest.mark.parametrize("name", ["talk_1.mp4", "cap12.mp4", "grid_lbbc2a.mpg"])
def test_both_backends_track_the_same_landmarks_in_other_clips(models: Path, shared: Path, name: str) -> None:
    with open_clip(shared / "media" / name) as clip:
        images = [frame.pixels for _ in range(40) if (frame := clip.read()) is not None]
    assert largest_difference(models, images) < 0.3


@needs_litert
@pytest.mark.slow
def test_litert_writes_nothing_to_the_terminal(models: Path, capfd: pytest.CaptureFixture[str]) -> None:
    run = load_network(models / LANDMARKS, ("Identity", "Identity_1"), backend="litert")
    run(np.zeros((1, 256, 256, 3), np.float32))
    assert capfd.readouterr() == ("", "")


@needs_litert
def test_auto_means_litert_when_it_can_be_imported() -> None:
    assert choose_backend("auto") == "litert"
    assert describe_backend().startswith("LiteRT ")


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (ModuleNotFoundError("No module named 'ai_edge_litert'"), "is not installed: pip install ai-edge-litert"),
        (ImportError("GLIBC_2.27 not found"), "cannot be imported, GLIBC_2.27 not found: pip install --force"),
        (TypeError("Descriptors cannot be created"), "cannot be imported, Descriptors cannot be created: pip"),
    ],
)
def test_auto_means_opencv_when_litert_cannot_be_imported(
    models: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, reason: str
) -> None:
    import_module = builtins.__import__

    def fail(name: str, *arguments: Any) -> Any:
        if name.startswith("ai_edge_litert"):
            raise error
        return import_module(name, *arguments)

    monkeypatch.delitem(sys.modules, "ai_edge_litert.interpreter", raising=False)
    monkeypatch.setattr(builtins, "__import__", fail)
    assert choose_backend("auto") == "opencv"
    assert choose_backend("litert") == "litert"
    assert describe_backend().startswith("OpenCV ") and reason in describe_backend()
    load_network(models / BLENDSHAPES, ("StatefulPartitionedCall:0",))
    with pytest.raises(ModelError, match=reason):
        load_network(models / BLENDSHAPES, ("StatefulPartitionedCall:0",), backend="litert")


@pytest.mark.parametrize(
    ("system", "machine", "python", "expected"),
    [
        *(("linux", machine, "3.11", True) for machine in ("x86_64", "aarch64")),
        *(("darwin", "arm64", python, True) for python in ("3.12", "3.13")),
        *(("win32", "AMD64", python, True) for python in ("3.11", "3.14")),
        *(("linux", machine, "3.11", False) for machine in ("riscv64", "armv7l")),
        ("darwin", "x86_64", "3.12", False),
        ("win32", "ARM64", "3.12", False),
        ("linux", "x86_64", "3.15", False),
    ],
)
def test_litert_is_required_where_it_has_a_wheel(system: str, machine: str, python: str, expected: bool) -> None:
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())["project"]
    (marker,) = [
        requirement.marker
        for requirement in map(Requirement, project["dependencies"])
        if requirement.name == "ai-edge-litert"
    ]
    assert marker is not None
    environment = {"sys_platform": system, "platform_machine": machine, "python_version": python}
    assert marker.evaluate(environment) is expected


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_models_may_lie_in_a_folder_of_any_name(models: Path, tmp_path: Path, backend: Backend) -> None:
    folder = tmp_path / os.fsdecode(b"na\xefve")
    folder.mkdir()
    (folder / BLENDSHAPES).write_bytes((models / BLENDSHAPES).read_bytes())
    [output] = load_network(folder / BLENDSHAPES, ("StatefulPartitionedCall:0",), backend=backend)(
        np.zeros((1, 146, 2), np.float32)
    )
    assert output.size == 52
