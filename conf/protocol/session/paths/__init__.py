"""The path of a session: candidate addresses, their validation, and the choice between the relay and a direct one."""
