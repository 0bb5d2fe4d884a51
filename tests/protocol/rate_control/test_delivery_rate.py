"""The delivery rate is that of the link while a queue grows, and the sender's otherwise."""

import pytest

from conf.protocol.feedback import Report
from conf.protocol.rate_control.delivery_rate import MAX_REMEMBERED, DeliveryRate

SIZE = 100  # bytes


def run(sent_kbps: float, link_kbps: float, *, seconds: float = 4.0, lose_every: int = 0) -> DeliveryRate:
    """Send datagrams through a link with a queue; a report each half second."""
    delivery, free_at, arrivals, sent, lost = DeliveryRate(), 0.0, [], 0, 0
    for step in range(round(100 * seconds)):
        now = step / 100
        while sent * SIZE * 8 / 1000 / sent_kbps <= now:
            delivery.on_sent(sent, SIZE, now)
            free_at = max(free_at, now) + SIZE * 8 / 1000 / link_kbps
            if not lose_every or sent % lose_every:
                arrivals.append((free_at, sent))
            sent += 1
        arrived = [(at, counter) for at, counter in arrivals if at <= now]
        if step % 50 == 49 and arrived:
            at, highest = arrived[-1]
            counters = {counter for _, counter in arrived}
            missing = sum(1 << i for i in range(min(highest, 63)) if highest - 1 - i not in counters)
            lost = highest + 1 - len(counters)
            delivery.on_report(Report(highest, missing, lost, 0, round((now - at) * 1000)), now + 0.04)
    return delivery


@pytest.mark.parametrize(("sent_kbps", "link_kbps"), [(16, 5), (16, 9), (6, 3), (16, 12)])
def test_a_queue_tells_the_rate_of_the_link(sent_kbps: float, link_kbps: float) -> None:
    delivery = run(sent_kbps, link_kbps)
    assert delivery.kbps == pytest.approx(link_kbps, rel=0.06)
    assert delivery.is_backing_up


@pytest.mark.parametrize("link_kbps", [16.5, 100])
def test_without_a_queue_it_is_the_rate_that_is_sent(link_kbps: float) -> None:
    delivery = run(16, link_kbps)
    assert delivery.kbps == pytest.approx(16, rel=0.06)
    assert not delivery.is_backing_up


def test_lost_datagrams_are_not_delivered() -> None:
    assert run(16, 100, lose_every=4).kbps == pytest.approx(12, rel=0.08)


def test_little_time_or_a_report_of_nothing_new_tells_nothing() -> None:
    assert run(16, 5, seconds=0.6).kbps is None
    delivery = run(16, 5)
    before = delivery.kbps
    delivery.on_report(Report(0, 0, 0, 0, 0), 9.0)
    assert delivery.kbps == before


def test_after_a_change_of_rate_it_is_measured_anew() -> None:
    delivery = run(16, 5)
    assert delivery.backlog_s > 4
    delivery.restart()
    assert delivery.kbps is None and not delivery.is_backing_up and delivery.backlog_s == 0


def test_memory_is_bounded() -> None:
    delivery = DeliveryRate()
    for counter in range(2 * MAX_REMEMBERED):
        delivery.on_sent(counter, SIZE, 0.0)
    assert len(delivery._sent) == MAX_REMEMBERED
