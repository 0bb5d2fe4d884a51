from conf.protocol.stream_clock import PeerStreamClock, StreamClock


def test_the_first_capture_time_is_stream_time_zero_until_a_restart() -> None:
    clock = StreamClock()
    assert (clock.offset(50.0), clock.offset(51.5), clock.offset(49.0)) == (0.0, 1.5, -1.0)
    assert (clock.stream_time(51.5), clock.stream_time(49.0)) == (1.5, 0.0)
    clock.restart()
    assert clock.stream_time(60.0) == 0.0 and clock.stream_time(60.25) == 0.25


def test_the_peers_time_goes_on_from_the_newest_that_is_known() -> None:
    clock = PeerStreamClock()
    assert clock.time(5.0) is None
    clock.advance(3.0, 100.0)
    assert clock.time(100.5) == 3.5
    clock.advance(2.0, 101.0)
    assert clock.time(101.0) == 4.0, "older content does not set the clock back"
    clock.advance(6.0, 102.0)
    assert clock.time(102.0) == 6.0
    clock.set(1.0, 103.0)
    assert clock.time(104.0) == 2.0
