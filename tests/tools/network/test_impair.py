from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tools.network.impair import Faults, Impairment

PROBABILITIES = st.floats(0, 1)


def run(
    faults: Faults, *, seed: int = 1, datagrams: int = 4000, every: float = 0.01
) -> list[list[tuple[float, bytes]]]:
    impairment = Impairment(faults, seed)
    return [impairment.transmit(i.to_bytes(4) * 10, i * every) for i in range(datagrams)]


@given(PROBABILITIES, PROBABILITIES, PROBABILITIES, PROBABILITIES, st.integers(0, 99))
def test_the_same_seed_gives_the_same_faults(
    loss: float, duplicate: float, corrupt: float, burst: float, seed: int
) -> None:
    faults = Faults(loss=loss, duplicate=duplicate, corrupt=corrupt, burst=burst, jitter_ms=10)
    assert run(faults, seed=seed, datagrams=50) == run(faults, seed=seed, datagrams=50)


def test_a_perfect_link_changes_nothing() -> None:
    assert run(Faults(), datagrams=20) == [[(i * 0.01, i.to_bytes(4) * 10)] for i in range(20)]


def test_each_fault_has_its_probability() -> None:
    lost = sum(not arrivals for arrivals in run(Faults(loss=0.1)))
    assert lost / 4000 == pytest.approx(0.1, abs=0.02)
    doubled = sum(len(arrivals) == 2 for arrivals in run(Faults(duplicate=0.2)))
    assert doubled / 4000 == pytest.approx(0.2, abs=0.03)
    damaged = sum(arrivals[0][1] != i.to_bytes(4) * 10 for i, arrivals in enumerate(run(Faults(corrupt=0.3))))
    assert damaged / 4000 == pytest.approx(0.3, abs=0.03)


def test_bursts_have_their_mean_length() -> None:
    lost = [not arrivals for arrivals in run(Faults(burst=0.01, burst_length=5), datagrams=20_000)]
    bursts = sum(b and not a for a, b in pairwise(lost))
    assert sum(lost) / bursts == pytest.approx(5, rel=0.2)


def test_jitter_only_adds_delay() -> None:
    arrivals = [a[0][0] - i * 0.01 for i, a in enumerate(run(Faults(delay_ms=50, jitter_ms=40)))]
    assert min(arrivals) >= 0.05 and 0.085 < max(arrivals) <= 0.0901


def test_a_rate_limit_passes_its_rate_and_drops_the_rest() -> None:
    arrivals = run(Faults(kbps=16), datagrams=2000)
    passed = [a[0][0] for a in arrivals if a]
    assert len(passed) * (40 + 28) * 8 / passed[-1] == pytest.approx(16_000, rel=0.06)


def test_an_outage_drops_every_datagram() -> None:
    lost = [not arrivals for arrivals in run(Faults(outage_at=1.0, outage=2.0), datagrams=500)]
    assert [i for i, is_lost in enumerate(lost) if is_lost] == list(range(100, 300))
