"""What the start window's controls do: settings, devices, calls. It draws nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from ipaddress import ip_address
from pathlib import Path

from conf.errors import ConfError, FileFormatError, explain
from conf.protocol.session.pairing_code import generate_code
from conf.settings import Settings, change_settings, load_settings
from conf.start.call_process import CallProcess
from conf.start.devices.camera_preview import CameraPreview
from conf.start.devices.choices import DeviceLists, find_devices
from conf.start.devices.device_thread import DeviceThread
from conf.start.devices.microphone_meter import MicrophoneMeter
from conf.start.devices.speaker_test import SpeakerTest
from conf.start.recent_calls import RecentCall, add_recent_call, load_recent_calls, save_recent_calls
from conf.start.state import CallTarget, StartState
from conf.transport.local_addresses import find_local_addresses, is_port_free

DEFAULT_CAMERA = "0"
KEPT_ASIDE = "the former settings file could not be read; it is kept as {}"
STILL_BUSY = "a camera or sound device does not answer: plug it in again if the call cannot use it"


@dataclass(frozen=True)
class Programs:
    """How a call and the animator are started, each as a process.

    connected_with : name or address of who is there now, from a message of a call; None for another message
    says_end : whether a message of a call says that the other participant has left
    code_in : the code by which this end is called over a relay, from a message; None for another message
    """

    start_call: Callable[[CallTarget, Settings], CallProcess]
    start_animator: Callable[[], CallProcess]
    connected_with: Callable[[str], str | None]
    says_end: Callable[[str], bool]
    code_in: Callable[[str], str | None]


@dataclass(frozen=True)
class Files:
    """Where settings and recent calls are kept."""

    settings: Path
    recent_calls: Path


class StartController:
    """State and devices of the start window.

    devices : None while they are being looked for
    addresses : of this machine; None while they are being looked for
    messages : of the call that is running, newest last
    """

    def __init__(self, programs: Programs, files: Files, *, random: Callable[[int], bytes], relay: str = "") -> None:
        """Read settings and recent calls, open the devices.

        random : n -> n random bytes; relay : in place of that of the settings, "" for none
        """
        self._programs = programs
        self._files = files
        self._random = random
        self.settings, notice = _load(files.settings)
        relay = relay or self.settings.relay or ""
        self.state = StartState(name=self.settings.name or "", notice=notice, relay=relay)
        self.recent = load_recent_calls(files.recent_calls)
        self.messages: list[str] = []
        self.devices: DeviceLists | None = None
        self.addresses: tuple[str, ...] | None = None
        self.camera: CameraPreview | None = None
        self.microphone: MicrophoneMeter | None = None
        self.speaker_test: SpeakerTest | None = None
        self._closing: list[CameraPreview | MicrophoneMeter | SpeakerTest] = []
        self._searches: list[DeviceThread] = []
        self._call: CallProcess | None = None
        self._end_message = ""
        self._recent: RecentCall | None = None  # that of the call
        self._animator: CallProcess | None = None
        self.find_devices()
        self.open_devices()

    @property
    def is_connected(self) -> bool:
        """Return whether the call's own window takes the place of this one."""
        return self._call is not None and self.state.connected

    def update(self) -> None:
        """Poll what runs beside the window."""
        if self._call is not None:
            self._follow_call(self._call)
        if self._animator is not None and not self._animator.is_running:
            if text := self._animator.end_text():
                self.state = replace(self.state, notice=text)
            self._animator = None

    def close(self) -> None:
        """End a call that is running, release the devices."""
        if self._call is not None:
            self._call.close()
        self.close_devices()

    # devices

    def find_devices(self) -> None:
        """Look for devices and this machine's addresses, in a thread."""
        self.devices = None

        def search(_: DeviceThread) -> None:
            self.devices = find_devices()
            self.addresses = find_local_addresses()

        self._searches.append(DeviceThread(search, name="search", retry=False))

    def open_devices(self) -> None:
        """Show the picture of the chosen camera and the level of the chosen microphone."""
        self._open_camera()
        self._open_microphone()

    def close_devices(self) -> bool:
        """Release all devices. Returns False if the library of one does not return."""
        for device in (self.camera, self.microphone, self.speaker_test):
            self._let_go(device)
        self.camera = self.microphone = self.speaker_test = None
        released = [device.close() for device in self._closing]
        self._closing.clear()
        return all(released)

    def test_speaker(self) -> None:
        """Play the test tone."""
        self._let_go(self.speaker_test)
        self.speaker_test = SpeakerTest(self.settings.speaker)

    def _open_camera(self) -> None:
        self._let_go(self.camera)
        self.camera = CameraPreview(self.settings.camera or DEFAULT_CAMERA)

    def _open_microphone(self) -> None:
        self._let_go(self.microphone)
        self.microphone = MicrophoneMeter(self.settings.microphone)

    def _let_go(self, device: CameraPreview | MicrophoneMeter | SpeakerTest | None) -> None:
        if device is not None:
            device.begin_close()
            self._closing.append(device)

    # settings

    def set_setting(self, name: str, value: object, /) -> None:
        """Keep a setting, None to unset it; what it is about changes at once."""
        if getattr(self.settings, name) == value:
            return
        self.settings = replace(self.settings, **{name: value})  # type: ignore[arg-type]
        try:
            _, kept_aside = change_settings(self._files.settings, {name: value})
        except ConfError as error:
            self.state = replace(self.state, notice=explain(error))
        else:
            if kept_aside is not None:
                self.state = replace(self.state, notice=KEPT_ASIDE.format(kept_aside))
        if name == "camera":
            self._open_camera()
        elif name == "microphone":
            self._open_microphone()

    def enter_name(self) -> None:
        """Keep the name that was typed, unless it has an error."""
        self.state = self.state.enter_name()
        if not self.state.name_error:
            self.set_setting("name", self.state.name.strip() or None)

    def enter_relay(self) -> None:
        """Keep the relay that was typed, unless it has an error."""
        self.state = self.state.enter_relay()
        if not self.state.relay_error:
            self.set_setting("relay", self.state.relay.strip() or None)

    # calls

    def call(self) -> None:
        """Call with the typed code, unless a field has an error."""
        self.enter_name()
        self.state = self.state.call()
        self._start()

    def wait_for_call(self) -> None:
        """Wait for a call over the relay or in this network, unless the relay has an error."""
        self.enter_name()
        self.state = self.state.wait_over_relay()
        self._start()

    def wait_at_port(self) -> None:
        """Wait for a call at a port of this machine, with a new code, unless the port has an error."""
        self.enter_name()
        self.state = self.state.wait(generate_code(self._random), is_port_free)
        self._start()

    def hang_up(self) -> None:
        """End the call, or the waiting for one; `update` goes back when it has ended."""
        if self._call is not None:
            self._call.hang_up()

    def choose_recent(self, call: RecentCall) -> None:
        """Type the address of a recent call."""
        self.state = self.state.with_field("address", call.address)

    def clear_recent(self) -> None:
        """Forget all recent calls."""
        self._keep_recent(())

    def animate(self) -> None:
        """Open the animator, unless it is open."""
        if self._animator is None:
            self._animator = self._programs.start_animator()

    def _start(self) -> None:
        if self.state.target is None:
            return
        released = self.close_devices()
        self.messages = [] if released else [STILL_BUSY]
        self._end_message = ""
        self._recent = None
        self._call = self._programs.start_call(self.state.target, self.settings)

    def _follow_call(self, call: CallProcess) -> None:
        was_running = call.is_running  # before the messages are read: the last ones are then read too
        for message in call.read_messages():
            if code := self._programs.code_in(message):
                self.state = self.state.show_code(code)
                continue
            self.messages.append(message)
            peer = self._programs.connected_with(message)
            if peer is not None:
                self._on_connected(peer)
            elif self.state.connected and self._programs.says_end(message):
                self._end_message = message
                call.hang_up()  # who waited would go on waiting, in the call's window
        if not was_running:
            self._call = None
            if self.state.connected:
                self._name_recent(str(call.figures().get("name", "")))
            self.state = self.state.end_call(call.end_text() or self._end_message)
            self.open_devices()

    def _on_connected(self, peer: str) -> None:
        """Remember a call. peer : name of the other participant, or its address"""
        self.state = self.state.connect()
        target = self.state.target
        address = target.address if target is not None and target.host is not None else ""
        name = peer
        if _is_ip_address(peer):
            address, name = address or peer, ""
        self._recent = RecentCall(address, datetime.now(UTC), name)
        self._remember(self._recent)

    def _name_recent(self, name: str) -> None:
        """Complete the last call with a name that was not known when it began."""
        if self._recent and name and name.isprintable():
            self.recent = tuple(call for call in self.recent if call is not self._recent)
            self._remember(replace(self._recent, name=name))

    def _remember(self, call: RecentCall) -> None:
        """Keep a call, unless nothing is known of it: over a relay nobody has an address."""
        if call.address or call.name:
            self._keep_recent(add_recent_call(self.recent, call))

    def _keep_recent(self, calls: Sequence[RecentCall]) -> None:
        self.recent = tuple(calls)
        try:
            save_recent_calls(self._files.recent_calls, calls)
        except ConfError as error:
            self.state = replace(self.state, notice=explain(error))


def _is_ip_address(text: str) -> bool:
    try:
        ip_address(text)
    except ValueError:
        return False
    return True


def _load(path: Path) -> tuple[Settings, str]:
    """Return the settings, and what is wrong with their file."""
    try:
        return load_settings(path), ""
    except FileFormatError as error:
        return Settings(), f"the settings are ignored: {explain(error)}"
