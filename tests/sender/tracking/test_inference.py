from pathlib import Path

import numpy as np
import pytest

from conf.errors import ModelError
from conf.sender.tracking.inference import Backend, choose_backend, load_network
from conf.sender.tracking.model_files import BLENDSHAPES, DETECTOR, LANDMARKS

has_litert = choose_backend("auto") == "litert"
needs_litert = pytest.mark.skipif(not has_litert, reason="ai-edge-litert is not installed")
BACKENDS: list[Backend] = ["opencv", "litert"] if has_litert else ["opencv"]

NETWORKS = [
    (DETECTOR, (1, 128, 128, 3), ("regressors", "classificators"), 1e-3),
    (LANDMARKS, (1, 256, 256, 3), ("Identity", "Identity_1"), 1e-2),
    (BLENDSHAPES, (1, 146, 2), ("StatefulPartitionedCall:0",), 1e-4),
]


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


def test_auto_means_litert_when_it_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: object())
    assert choose_backend("auto") == "litert"
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert choose_backend("auto") == "opencv"
    assert choose_backend("litert") == "litert"
