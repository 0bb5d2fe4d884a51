"""Unwrapping of counters of which only the low bits are transmitted."""


def unwrap(low: int, /, *, bits: int, expected: int) -> int:
    """Return the non-negative integer nearest to `expected` whose lowest `bits` bits are `low`.

    Source: RFC 3550, Appendix A.1, with unbounded integers in place of wrap-around.
    """
    span = 1 << bits
    candidate = expected - (expected - low + span // 2) % span + span // 2
    return candidate if candidate >= 0 else candidate + span
