"""What the start window shows, without a window: the page, what was typed and what is wrong with it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from conf.protocol.address import DEFAULT_PORT, format_address, parse_address
from conf.protocol.session.pairing_code import normalise_code
from conf.settings import read_setting

Page = Literal["home", "waiting", "calling"]
NO_ADDRESS = "type the address that the other one's window shows"
NO_CODE = "type the code that the other one's window shows"
NO_PORT = "a port is a number from 1 to 65535"
USED_PORT = "another program uses port {port}: choose another"


@dataclass(frozen=True)
class CallTarget:
    """Whom to call, or where to wait. host : None to wait; code : as normalise_code returns it"""

    host: str | None
    port: int
    code: str

    @property
    def address(self) -> str:
        """Return the address of who is called as it is typed; without the default port."""
        text = format_address((self.host or "", self.port))
        return text.removesuffix(f":{DEFAULT_PORT}") if self.host else text


@dataclass(frozen=True)
class StartState:
    """Immutable state of the window.

    name, address, code, port : texts of fields; each has its error, "" if there is none
    notice : about the last call, or what could not be done
    target : of the call that is prepared or made
    connected : whether the call's other participant is there
    """

    page: Page = "home"
    name: str = ""
    address: str = ""
    code: str = ""
    port: str = str(DEFAULT_PORT)
    name_error: str = ""
    address_error: str = ""
    code_error: str = ""
    port_error: str = ""
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
        return any((self.name_error, self.address_error, self.code_error, self.port_error, self.notice))

    def without_complaints(self) -> "StartState":
        """Return the state without errors and notice."""
        return replace(self, name_error="", address_error="", code_error="", port_error="", notice="")

    def call(self) -> "StartState":
        """Return the state with the target of a call to the typed address, or with the errors of its fields."""
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
