import pytest

from conf.protocol.feedback import Report
from conf.protocol.portrait.chunk_budget import STARTUP_BYTES
from conf.protocol.rate_control.circuit_breaker import OPEN_AFTER_S
from conf.protocol.rate_control.rate_levels import RATE_LEVELS, VOICE_LEVELS, VoiceMode
from conf.protocol.rate_control.send_budget import (
    DATAGRAM_OVERHEAD,
    MAX_CHUNK_DATAGRAM,
    VOICE_OVERHEAD,
    RateOptions,
    SendBudget,
    highest_level,
)

RICH, LIVE, BUNDLED, NARROW = RATE_LEVELS


def report(budget: SendBudget, count: int, *, rtt_s: float = 0.1, begin: float = 0.0, lost: int = 0) -> float:
    """Apply reports, two a second, each of 8 datagrams. Returns the time of the last."""
    now = begin
    for number in range(count):
        now = begin + 0.5 * number
        counter = round(now * 16) + 8
        budget.round_trip.on_sent(counter, now - rtt_s)
        budget.on_report(Report(counter, 0, min(lost * number, counter), 7, 0), now)
    return now


@pytest.mark.parametrize(
    ("kbps", "level"),
    [
        (None, LIVE),
        (100.0, LIVE),
        (5.8, LIVE),
        (5.7, BUNDLED),
        (4.0, BUNDLED),
        (3.9, NARROW),
        (2.4, NARROW),
        (1.0, NARROW),
    ],
)
def test_the_first_level_is_the_highest_within_the_limit_but_at_most_live(kbps: float | None, level: object) -> None:
    assert RATE_LEVELS[highest_level(RATE_LEVELS, kbps)] == level
    assert SendBudget(RateOptions(kbps=kbps), 0.0).level == level


def test_the_level_follows_the_reports_but_not_above_the_limit() -> None:
    budget = SendBudget(RateOptions(kbps=4.5), 0.0)
    now = report(budget, 80)
    assert budget.level == BUNDLED
    report(budget, 30, begin=now + 0.5, lost=4)
    assert budget.level == NARROW and budget.loss.fraction > 0.3


def test_a_fixed_profile_stays() -> None:
    budget = SendBudget(RateOptions("rich"), 0.0)
    report(budget, 60, lost=4)
    assert (budget.level.profile, budget.level.bundling) == ("rich", 1)


def test_reports_give_round_trip_and_jitter_and_keep_the_breaker_closed() -> None:
    budget = SendBudget(RateOptions(), 0.0)
    assert budget.jitter_ms is None and budget.round_trip.smoothed_s is None
    now = report(budget, 30)
    assert budget.jitter_ms == 7.0 and budget.round_trip.smoothed_s == pytest.approx(0.1)
    assert not budget.is_stopped(now + OPEN_AFTER_S - 0.1) and not budget.consume_probe(now + OPEN_AFTER_S - 0.1)
    assert budget.is_stopped(now + OPEN_AFTER_S) and budget.consume_probe(now + OPEN_AFTER_S)
    budget.restart(now + OPEN_AFTER_S)
    assert not budget.is_stopped(now + OPEN_AFTER_S)


def test_a_restart_begins_the_startup_of_the_portrait_again() -> None:
    budget = SendBudget(RateOptions(portrait_kbps=1e6), 0.0)
    for step in range(STARTUP_BYTES // 80 + 1):
        assert budget.chunks.consume(80, float(step))
    assert not budget.chunks.in_startup
    budget.restart(0.0)
    assert budget.chunks.in_startup


def test_the_loss_of_a_new_session_is_measured_anew() -> None:
    budget = SendBudget(RateOptions(), 0.0)
    now = report(budget, 200, lost=2)
    assert budget.loss.fraction > 0.1
    budget.restart(now)
    assert budget.loss.expected == 0 and budget.loss.fraction == 0
    report(budget, 30, begin=now)
    assert budget.loss.expected > 0 and budget.loss.fraction == 0


def test_the_limit_counts_every_datagram() -> None:
    budget, free = SendBudget(RateOptions(kbps=16.0), 0.0), SendBudget(RateOptions(), 0.0)
    assert budget.consume(1250, 0.0) and not budget.consume(1, 0.0)
    assert all(free.consume(10**6, 0.0) for _ in range(10))


def test_chunks_are_allowed_while_reports_arrive_and_the_queue_is_low() -> None:
    budget = SendBudget(RateOptions(), 0.0)
    now = report(budget, 10)
    assert budget.allows_chunk(now) and not budget.allows_chunk(now + OPEN_AFTER_S)
    now = report(budget, 5, rtt_s=0.1 + 0.149, begin=now + 0.5)
    assert budget.allows_chunk(now), "0.75 of 0.2 s is not exceeded"
    now = report(budget, 5, rtt_s=0.1 + 0.151, begin=now + 0.5)
    assert not budget.allows_chunk(now)


@pytest.mark.parametrize(("profile", "is_allowed"), [("auto", True), ("live", True), ("rich", True), ("narrow", False)])
def test_a_modem_gets_no_chunks(profile: str, is_allowed: bool) -> None:
    assert SendBudget(RateOptions(profile), 0.0).allows_chunk(0.0) == is_allowed


def test_the_automatic_narrow_level_gets_chunks() -> None:
    budget = SendBudget(RateOptions(), 0.0)
    now = report(budget, 60, lost=4)
    assert budget.level == NARROW and budget.allows_chunk(now)


def test_chunks_need_headroom_under_a_limit() -> None:
    assert MAX_CHUNK_DATAGRAM == 28 + 19 + 6 + 76
    budget = SendBudget(RateOptions(kbps=16.0), 0.0)
    assert budget.consume(625 - MAX_CHUNK_DATAGRAM, 0.0) and budget.allows_chunk(0.0)
    assert budget.consume(1, 0.0) and not budget.allows_chunk(0.0)


def test_what_was_sent_besides_the_chunks_counts_as_motion() -> None:
    budget = SendBudget(RateOptions(), 0.0)
    counted = []
    budget.chunks.add_motion = lambda size, now: counted.append((size, now))  # type: ignore[method-assign]
    budget.on_datagrams_sent(100, 1.0)
    assert budget.chunks.consume(80, 2.0, overhead=2)
    budget.on_datagrams_sent(150, 2.0)
    budget.on_datagrams_sent(50, 3.0)
    assert budget.chunks.consume(80, 100.0, overhead=2)
    budget.on_datagrams_sent(0, 100.0)  # the chunk was dropped by the limit
    budget.on_datagrams_sent(60, 101.0)
    assert counted == [(100, 1.0), (68, 2.0), (50, 3.0), (60, 101.0)]


@pytest.mark.parametrize(
    ("kbps", "voice", "codec", "bit_rate"),
    [
        (None, VoiceMode.AUTOMATIC, "opus", 9000),
        (16.0, VoiceMode.AUTOMATIC, "opus", 9000),
        (15.9, VoiceMode.AUTOMATIC, "opus", 6000),
        (9.5, VoiceMode.AUTOMATIC, "codec2", 3200),
        (5.9, VoiceMode.AUTOMATIC, "codec2", 2400),
        (2.4, VoiceMode.AUTOMATIC, "codec2", 1200),
        (2.3, VoiceMode.AUTOMATIC, None, None),
        (9.5, VoiceMode.OPUS, None, None),
        (9.6, VoiceMode.OPUS, "opus", 6000),
        (16.0, VoiceMode.CODEC2, "codec2", 3200),
        (16.0, VoiceMode.OFF, None, None),
    ],
)
def test_the_voice_is_that_of_the_highest_level_within_the_limit(
    kbps: float | None, voice: VoiceMode, codec: str | None, bit_rate: int | None
) -> None:
    budget = SendBudget(RateOptions(kbps=kbps, voice=voice), 0.0)
    chosen = budget.voice_format
    assert (chosen.codec if chosen else None, chosen.bit_rate if chosen else None) == (codec, bit_rate)
    assert chosen is None or budget.level.voice == chosen
    assert chosen is not None or budget.level in RATE_LEVELS


@pytest.mark.parametrize(
    ("profile", "kbps", "motion", "bit_rate"),
    [
        ("narrow", None, "narrow", 3200),
        ("narrow", 16.0, "narrow", 3200),
        ("narrow", 2.4, "slow", 1200),
        ("live", None, "voice", 9000),
        ("live", 9.6, "voice", 6000),
        ("live", 6.0, "live", 3200),  # no level with voice has its precision
        ("rich", 16.0, "rich", 9000),
    ],
)
def test_with_voice_a_fixed_profile_means_the_levels_of_its_precision(
    profile: str, kbps: float | None, motion: str, bit_rate: int
) -> None:
    budget = SendBudget(RateOptions(profile, kbps=kbps, voice=VoiceMode.AUTOMATIC), 0.0)
    assert budget.level.profile == motion and budget.voice_format and budget.voice_format.bit_rate == bit_rate
    losses(budget, 0.5, 0.0, seconds=60.0)
    assert (budget.level.profile == "slow") == (profile == "narrow")
    assert (budget.level.profile == "voice") == (profile == "live" and kbps != 6.0)


def losses(budget: SendBudget, fraction: float, begin: float, seconds: float = 30.0) -> float:
    """Apply reports of 5 datagrams each half second, a fraction of them lost. Returns the time of the last."""
    highest, lost, now = (*budget.loss._totals[-1][1:], begin) if budget.loss._totals else (0, 0, begin)
    for step in range(round(2 * seconds)):
        now = begin + step / 2
        highest += 5
        lost += round(fraction * 5 * (step + 1)) - round(fraction * 5 * step)
        budget.on_report(Report(highest, 0, lost, 7, 0), now)
    return now


@pytest.mark.parametrize("kbps", [16.0, 9.6, 6.0, 4.8])
def test_packets_are_repeated_while_much_is_lost(kbps: float) -> None:
    budget = SendBudget(RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC), 0.0)
    first = budget.voice_format
    assert first and not first.repeated
    now = losses(budget, 0.01, 0.0)
    assert budget.voice_format == first
    now = losses(budget, 0.1, now + 0.5)
    repeated = budget.voice_format
    assert repeated and repeated.repeated and repeated != first
    losses(budget, 0.0, now + 0.5)
    assert budget.voice_format == first


def test_only_heavy_loss_lowers_a_level_with_voice_and_a_queue_does() -> None:
    budget = SendBudget(RateOptions(voice=VoiceMode.AUTOMATIC), 0.0)
    now = losses(budget, 0.2, 0.0)
    assert budget.level == VOICE_LEVELS[0]
    losses(budget, 0.5, now + 0.5)
    assert budget.level == VOICE_LEVELS[-1]
    budget = SendBudget(RateOptions(voice=VoiceMode.AUTOMATIC), 0.0)
    now = report(budget, 10)
    report(budget, 40, rtt_s=0.6, begin=now + 0.5)
    assert budget.level == VOICE_LEVELS[-1]


def test_the_room_beside_voice_follows_what_its_packets_have_needed() -> None:
    free = SendBudget(RateOptions(voice=VoiceMode.AUTOMATIC), 0.0)
    assert free.room_beside_voice(100, 0.0) == float("inf") and free.consume_voice(10**6, 0.0)
    budget = SendBudget(RateOptions(kbps=16.0, voice=VoiceMode.AUTOMATIC), 0.0)
    voice_format = budget.voice_format
    assert voice_format
    before = budget.room_beside_voice(100, 0.0)
    assert before == 20_000 - 167 * (VOICE_OVERHEAD + 68) - 100
    for _ in range(100):
        budget.on_voice(voice_format, 50)
    assert budget.room_beside_voice(100, 0.0) == 20_000 - 167 * (VOICE_OVERHEAD + 51) - 100
    assert budget.consume_voice(20_000, 0.0) and not budget.consume_voice(1, 0.0)


def test_a_chunk_beside_voice_needs_its_own_size_of_room() -> None:
    budget = SendBudget(RateOptions(kbps=16.0, voice=VoiceMode.AUTOMATIC), 0.0)
    size = MAX_CHUNK_DATAGRAM - DATAGRAM_OVERHEAD + 2
    assert budget.allows_chunk(0.0, size) and not budget.allows_chunk(0.0, size - 1)


class SlowLink:
    """A link of a rate with a long queue, and a sender that uses its level. Reports each half second."""

    def __init__(self, kbps: float) -> None:
        self.budget = SendBudget(RateOptions(voice=VoiceMode.AUTOMATIC), 0.0)
        self.kbps = kbps
        self.now = self._free_at = self._next = 0.0
        self._counter = 0
        self._arrivals: list[tuple[float, int]] = []
        self.levels = [self.budget.level.kbps]

    @property
    def queue_s(self) -> float:
        """Seconds that a datagram waits in the queue."""
        return max(0.0, self._free_at - self.now)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(100 * seconds)):
            self.now += 0.01
            voice = self.budget.voice_format
            assert voice
            if self.now >= self._next:
                self._next = self.now + voice.packet_s
                if not self.budget.is_paused(self.now):
                    size = round(0.92 * self.budget.level.kbps * 125 * voice.packet_s)
                    self.budget.on_sent(self._counter, size, self.now)
                    self._free_at = max(self._free_at, self.now) + size * 8 / 1000 / self.kbps
                    self._arrivals.append((self._free_at + 0.04, self._counter))
                    self._counter += 1
            arrived = [arrival for arrival in self._arrivals if arrival[0] <= self.now]
            if round(self.now * 100) % 50 == 0 and arrived:
                at, highest = arrived[-1]
                self.budget.on_report(Report(highest, 0, 0, 0, round((self.now - at) * 1000)), self.now + 0.04)
                self.levels.append(self.budget.level.kbps)


@pytest.mark.parametrize(("kbps", "level"), [(12.0, 9.6), (7.0, 6.0), (5.0, 4.8), (3.0, 2.4)])
def test_the_level_of_a_slow_link_is_found_in_one_step_and_its_queue_is_emptied(kbps: float, level: float) -> None:
    link = SlowLink(kbps)
    link.run(3.5)
    assert link.levels[-1] == level == min(link.levels)
    link.run(6.0)
    assert min(link.levels) == level and link.queue_s < 0.4
    link.run(30.0)
    assert min(link.levels) == level and link.queue_s < 1.2, "what is tried again later is soon taken back"


def test_a_fast_link_keeps_its_level() -> None:
    link = SlowLink(20.0)
    link.run(30.0)
    assert set(link.levels) == {16.0}
