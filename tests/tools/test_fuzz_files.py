import json
import random
from pathlib import Path

import pytest

from tools.fuzz_files import READERS, fuzz, make_samples, mutate, mutate_gltf


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return make_samples(tmp_path_factory.mktemp("samples"))


@pytest.mark.slow
def test_there_is_a_readable_sample_of_every_format(samples: dict[str, bytes], tmp_path: Path) -> None:
    assert samples.keys() == READERS.keys()
    for kind in samples.keys() - {"mtl"}:
        path = tmp_path / f"sample.{kind}"
        path.write_bytes(samples[kind])
        READERS[kind](path)


@pytest.mark.parametrize("kind", ["obj", "gltf", "vrm"])
def test_a_case_is_known_by_its_number(samples: dict[str, bytes], kind: str) -> None:
    change = mutate_gltf if kind != "obj" else lambda sample, rng: mutate(sample, rng, text=True)
    first, again, other = (change(samples[kind], random.Random(seed)) for seed in (1, 1, 2))
    assert first == again != other


def test_a_changed_glb_is_whole_but_for_the_change(samples: dict[str, bytes]) -> None:
    for seed in range(50):
        data = mutate_gltf(samples["vrm"], random.Random(seed))
        size = int.from_bytes(data[12:16], "little")
        assert int.from_bytes(data[8:12], "little") == len(data)
        json.loads(data[20 : 20 + size])


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["obj", "mtl", "gltf", "dpc", "mp4"])
def test_cases_give_data_or_one_error(samples: dict[str, bytes], tmp_path: Path, kind: str) -> None:
    outcome = fuzz(kind, samples[kind], 40, 1, tmp_path)
    assert outcome.cases == outcome.data + outcome.errors == 40 and outcome.examples == []
