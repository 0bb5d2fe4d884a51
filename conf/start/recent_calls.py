"""The last calls: with whom and when, never with which code. Kept beside the settings, where the system keeps state."""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from conf.atomic_write import atomic_write, report_write_errors
from conf.protocol.address import parse_address

MAX_CALLS = 20
MAX_FILE_BYTES = 1 << 16
MAX_LETTERS = 255  # of a host's name, as in DNS
_OWNER_ONLY = 0o600  # who called whom is nobody else's business
_DAY = "%a %d %b"


@dataclass(frozen=True)
class RecentCall:
    """A call that was connected.

    address : HOST or HOST:PORT, as a user types it; "" of a call that was received
    time : when it began, aware of its time zone
    name : of the other participant; "" if it gave none
    """

    address: str
    time: datetime
    name: str = ""


def recent_calls_path() -> Path:
    """Return the path of the file where the system keeps the state of programs."""
    from platformdirs import user_state_path  # here: it is needed once, after the window is open

    return user_state_path("conf", appauthor=False) / "recent_calls.json"


def load_recent_calls(path: Path, /) -> tuple[RecentCall, ...]:
    """Return the calls of a file, newest first; what is not one is left out. A missing file has none."""
    try:
        with path.open("rb") as file:
            entries = json.loads(file.read(MAX_FILE_BYTES))
    except (OSError, ValueError, RecursionError):
        return ()
    calls = (_read_call(entry) for entry in (entries if isinstance(entries, list) else ()))
    return tuple(call for call in calls if call is not None)[:MAX_CALLS]


def save_recent_calls(path: Path, calls: Sequence[RecentCall], /) -> None:
    """Write the calls. Raises ConfError if the file cannot be written."""
    entries = [{"address": call.address, "time": call.time.isoformat(), "name": call.name} for call in calls]
    with report_write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as partial:
            partial.touch(_OWNER_ONLY)
            partial.write_text(json.dumps(entries, indent=1), encoding="utf-8")
        os.chmod(path, _OWNER_ONLY)


def add_recent_call(calls: Sequence[RecentCall], call: RecentCall, /) -> tuple[RecentCall, ...]:
    """Return the calls with a new one first, at most MAX_CALLS; an older one of the same address or name is left out.

    Only calls that were received are told apart by their names.
    """
    key = _key(call)
    others = (other for other in calls if _key(other) != key)
    return (call, *others)[:MAX_CALLS]


def describe_time(time: datetime, now: datetime, /) -> str:
    """Return when a call was, in the time zone of `now`: 14:05, yesterday 14:05, Tue 24 Nov, 24 Nov 2025."""
    local = time.astimezone(now.tzinfo)
    days = (now.date() - local.date()).days
    if days <= 0:
        return f"{local:%H:%M}"
    if days == 1:
        return f"yesterday {local:%H:%M}"
    return f"{local:{_DAY}}" if local.year == now.year else f"{local:%d %b %Y}"


def _key(call: RecentCall) -> tuple[str, str]:
    return call.address, "" if call.address else call.name


def _read_call(entry: Any) -> RecentCall | None:
    match entry:
        case {"address": str(address), "time": str(time), "name": str(name)}:
            if not address and not name:
                return None
            try:
                if address:
                    parse_address(address)
                parsed = datetime.fromisoformat(time)
            except ValueError:
                return None
            is_text = (address + name).isprintable() and len(address) <= MAX_LETTERS and len(name) <= MAX_LETTERS
            return RecentCall(address, parsed, name) if parsed.tzinfo and is_text else None
    return None
