"""What the start window shows, without a window: the page, what was typed and what is wrong with it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from conf.protocol.address import DEFAULT_PORT, DEFAULT_RELAY_PORT, format_address, parse_address
from conf.protocol.session.pairing_code import nameplate_of, normalise_code
from conf.settings import read_setting

Page = Literal["home", "waiting", "calling"]
NO_ADDRESS = "type the address that the other one's window shows"
NO_CODE = "type the code that the other one's window shows"
NO_PORT = "a port is a number from 1 to 65535"
USED_PORT = "another program uses port {port}: choose another"


@dataclass(frozen=True)
class CallTarget:
    """Whom to call, or where to wait.

    host : None to wait, and for calls over a relay; port : 0 for these
    code : as normalise_code returns it; "" while it is not known, as the relay has to say which numbers are free
    relay : HOST or HOST:PORT, "" to find the other one in this network, None for a direct call
    nameplate : of who is called over the relay, "" to wait
    """

    host: str | None
    port: int
    code: str
    relay: str | None = None
    nameplate: str = ""

    @property
    def is_waiting(self) -> bool:
        """Whether this end waits to be called."""
        return self.host is None and not self.nameplate

    @property
    def address(self) -> str:
        """Return who is called as it is typed: the address without the default port, or the number of the code."""
        if self.nameplate:
            return self.nameplate
        text = format_address((self.host or "", self.port))
        return text.removesuffix(f":{DEFAULT_PORT}") if self.host else text


@dataclass(frozen=True)
class StartState:
    """Immutable state of the window.

    name, address, code, port, relay : texts of fields; each has its error, "" if there is none
    notice : about the last call, or what could not be done
    target : of the call that is prepared or made
    connected : whether the call's other participant is there
    """

    page: Page = "home"
    name: str = ""
    address: str = ""
    code: str = ""
    port: str = str(DEFAULT_PORT)
    relay: str = ""
    name_error: str = ""
    address_error: str = ""
    code_error: str = ""
    port_error: str = ""
    relay_error: str = ""
    notice: str = ""
    target: CallTarget | None = None
    connected: bool = False

    def with_field(self, field: str, text: str, /) -> "StartState":
        """Return the state after typing into a field; its error is gone."""
        if getattr(self, field) == text:
            return self
        return replace(self, **{field: text, f"{field}_error": ""})  # type: ignore[arg-type]

    @property
    def complains(self) -> bool:
        """Return whether an error or a notice is shown."""
        errors = (self.name_error, self.address_error, self.code_error, self.port_error, self.relay_error)
        return any((*errors, self.notice))

    @property
    def needs_address(self) -> bool:
        """Return whether the typed code leads to no relay: it does with a number in front."""
        return not self.code.strip()[:1].isdecimal()

    def without_complaints(self) -> "StartState":
        """Return the state without errors and notice."""
        return replace(self, name_error="", address_error="", code_error="", port_error="", relay_error="", notice="")

    def call(self) -> "StartState":
        """Return the state with the target of a call with the typed code, or with the errors of its fields.

        A code with a number in front leads over the relay, any other to the typed address.
        """
        if not self.needs_address:
            return self._call_over_relay()
        address_error, code_error, host, port, code = "", "", "", 0, ""
        try:
            host, port = parse_address(self.address.strip())
        except ValueError as error:
            address_error = str(error) if self.address.strip() else NO_ADDRESS
        try:
            code = normalise_code(self.code)
        except ValueError as error:
            code_error = str(error) if self.code.strip() else NO_CODE
        state = replace(self, address_error=address_error, code_error=code_error, notice="")
        if address_error or code_error:
            return state
        return replace(state, page="calling", target=CallTarget(host, port, code), connected=False)

    def _call_over_relay(self) -> "StartState":
        try:
            code = normalise_code(self.code)
        except ValueError as error:
            return replace(self, code_error=str(error), address_error="", notice="")
        state = replace(self.enter_relay(), code_error="", address_error="", notice="")
        if state.relay_error:
            return state
        target = CallTarget(None, 0, code, relay=self.relay.strip(), nameplate=nameplate_of(code))
        return replace(state, page="calling", target=target, connected=False)

    def wait_over_relay(self) -> "StartState":
        """Return the state that waits for a call over the relay, or with the error of its field."""
        state = replace(self.enter_relay(), notice="")
        if state.relay_error:
            return state
        return replace(state, page="waiting", target=CallTarget(None, 0, "", relay=self.relay.strip()), connected=False)

    def show_code(self, code: str, /) -> "StartState":
        """Return the state in which the code is known by which this end is called."""
        return replace(self, target=replace(self.target, code=code)) if self.target else self

    def wait(self, code: str, is_free: Callable[[int], bool], /) -> "StartState":
        """Return the state that waits for a call with a new code, or with the error of the port.

        is_free : whether a port can be used
        """
        text = self.port.strip()
        if not (text.isdecimal() and 1 <= int(text) <= 65535):
            return replace(self, port_error=NO_PORT, notice="")
        if not is_free(int(text)):
            return replace(self, port_error=USED_PORT.format(port=int(text)), notice="")
        target = CallTarget(None, int(text), code)
        return replace(self, page="waiting", port_error="", notice="", target=target, connected=False)

    def connect(self) -> "StartState":
        """Return the state in which the other participant is there."""
        return replace(self, connected=True)

    def end_call(self, notice: str, /) -> "StartState":
        """Return the state after a call: the code is of no more use, the address is."""
        is_used = self.connected and self.page == "calling"
        return replace(
            self, page="home", target=None, connected=False, notice=notice, code="" if is_used else self.code
        )

    def enter_name(self) -> "StartState":
        """Return the state with the error of the name, if it has one."""
        try:
            if self.name.strip():
                read_setting("name", self.name)
        except ValueError as error:
            return replace(self, name_error=str(error).removeprefix("name: "))
        return replace(self, name_error="")

    def enter_relay(self) -> "StartState":
        """Return the state with the error of the relay, if it has one."""
        try:
            if self.relay.strip():
                parse_address(self.relay.strip(), default_port=DEFAULT_RELAY_PORT)
        except ValueError as error:
            return replace(self, relay_error=str(error))
        return replace(self, relay_error="")
