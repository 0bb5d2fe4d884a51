"""Recent calls: order, number, what a damaged file becomes."""

import json
import os
import stat
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ConfError
from conf.start.recent_calls import (
    MAX_CALLS,
    RecentCall,
    add_recent_call,
    describe_time,
    load_recent_calls,
    recent_calls_path,
    save_recent_calls,
)

NOW = datetime(2026, 3, 2, 12, 0, tzinfo=timezone(timedelta(hours=1)))
host = st.from_regex(r"[a-z]{1,8}", fullmatch=True)
calls = st.lists(
    st.builds(RecentCall, host, st.datetimes(timezones=st.just(UTC)), st.sampled_from(["", "Anna", "Höß"]))
)


def test_calls_are_read_as_they_were_written(tmp_path: Path) -> None:
    path = tmp_path / "new" / "recent_calls.json"
    written = (RecentCall("10.0.0.7:5005", NOW, "Anna Höß"), RecentCall("[::1]:6000", NOW - timedelta(1)))
    save_recent_calls(path, written)
    assert load_recent_calls(path) == written
    if os.name == "posix":
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
    save_recent_calls(path, ())
    assert load_recent_calls(path) == ()


@given(calls)
def test_the_newest_is_first_and_an_address_is_listed_once(made: list[RecentCall]) -> None:
    listed: tuple[RecentCall, ...] = ()
    for call in made:
        listed = add_recent_call(listed, call)
        assert listed[0] == call
    addresses = [call.address for call in listed]
    assert len(set(addresses)) == len(addresses) <= MAX_CALLS
    assert addresses == list(dict.fromkeys(call.address for call in reversed(made)))[:MAX_CALLS]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff",
        b"{}",
        b"[" * 100_000,
        b"[1, null, {}]",
        json.dumps([{"address": "a:99999", "time": NOW.isoformat(), "name": ""}]).encode(),
        json.dumps([{"address": "a", "time": "yesterday", "name": ""}]).encode(),
        json.dumps([{"address": "a", "time": "2026-01-01T00:00", "name": ""}]).encode(),
        json.dumps([{"address": "a", "time": NOW.isoformat(), "name": "\x1b"}]).encode(),
    ],
)
def test_what_is_no_call_is_left_out(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "recent_calls.json"
    path.write_bytes(content)
    assert load_recent_calls(path) == ()


def test_received_calls_are_told_apart_by_name(tmp_path: Path) -> None:
    anna, bea = RecentCall("", NOW, "Anna"), RecentCall("", NOW, "Bea")
    assert add_recent_call(add_recent_call((anna,), bea), anna) == (anna, bea)
    save_recent_calls(tmp_path / "r.json", (anna, RecentCall("", NOW)))
    assert load_recent_calls(tmp_path / "r.json") == (anna,)


def test_a_missing_file_has_no_calls_and_a_folder_that_cannot_be_is_an_error(tmp_path: Path) -> None:
    assert load_recent_calls(tmp_path / "no.json") == ()
    (tmp_path / "file").touch()
    with pytest.raises(ConfError, match="cannot be written"):
        save_recent_calls(tmp_path / "file" / "recent_calls.json", ())


@pytest.mark.parametrize(
    ("time", "text"),
    [
        (NOW - timedelta(hours=2), "10:00"),
        (datetime(2026, 3, 2, 0, 30, tzinfo=UTC), "01:30"),
        (datetime(2026, 3, 1, 23, 30, tzinfo=UTC), "00:30"),  # today here
        (NOW - timedelta(hours=13), "yesterday 23:00"),
        (NOW - timedelta(days=3), "Fri 27 Feb"),
        (NOW - timedelta(days=90), "02 Dec 2025"),
        (NOW + timedelta(days=3), "12:00"),  # a clock that was wrong
    ],
)
def test_times_are_short(time: datetime, text: str) -> None:
    assert describe_time(time, NOW) == text


def test_the_file_is_where_the_system_keeps_state() -> None:
    assert recent_calls_path().parts[-2:] == ("conf", "recent_calls.json")
