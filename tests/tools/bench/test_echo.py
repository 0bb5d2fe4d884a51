"""The bench of echo cancellation measures what it says, on sounds whose figures are known."""

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE, Samples
from tests.support.synthetic_voice import noise, whisper
from tools.bench.echo import Row, Speech, converged_s, erle, measure, scenes, worst
from tools.bench.rooms import ROOMS, Scene


def test_the_reduction_of_a_known_factor_is_found() -> None:
    sound = noise(2.0, -20)
    assert erle(sound, sound // 10, 0.5, 1.5) == pytest.approx(20, abs=0.1)


def test_convergence_ends_with_the_first_loud_window_that_is_quieter() -> None:
    before = np.concatenate([np.zeros(SAMPLE_RATE, np.int16), noise(3.0, -20)])
    after = before.copy()
    after[2 * SAMPLE_RATE :] //= 20
    assert converged_s(before, after) == pytest.approx(2.5)
    assert converged_s(before, before) is None


def test_the_rows_cover_all_rooms_and_delays() -> None:
    rows = scenes()
    assert {(scene.room, scene.delay_s) for scene in rows.values()} >= {
        (room, delay_s) for room in ROOMS for delay_s in (0.02, 0.06, 0.12, 0.2)
    }
    assert {scene.drift_ppm for scene in rows.values()} >= {-100, 0, 100}


def test_the_worst_figures_are_those_of_no_single_row() -> None:
    rows = [Row("a", 40, 30, 1.5, 0.5, 0.9, 0.1, 10, 20), Row("b", 35, 45, 1.2, 0.5, 0.95, 0.05, 10, 20)]
    assert worst(rows) == {"erle_3s": 35, "erle_10s": 30, "stoi_loss": 0.1, "converged_s": 1.5}
    assert "converged_s" not in worst([Row("c", 10, 10, None, 0.5, 0.9, 0.1, 10, 20)])


@pytest.mark.slow
def test_a_canceller_that_does_nothing_has_figures_of_nothing() -> None:
    def nothing(recorded: Samples, played: Samples, scene: Scene) -> tuple[Samples, float]:
        return recorded, 0.0

    far = whisper(11.0, seed=1, dbfs=-20)
    speech = Speech(far, whisper(3.0, seed=2).astype(float), 6 * SAMPLE_RATE)
    row = measure("nothing", Scene("desk"), speech, nothing, alone=1.0, seed=1)
    assert row.erle_3s == row.erle_10s == 0 and row.converged_s is None and row.delay_ms < 1
    assert row.stoi == pytest.approx(row.stoi_without, abs=1e-3) and row.stoi_loss == pytest.approx(1 - row.stoi)
    assert 0.5 < row.stoi < 0.95
