"""Start of the program, for `conf` and `python -m conf`.

Once this module is imported, Ctrl-C ends the program without a traceback: at once while other modules are imported,
through KeyboardInterrupt while a command runs, and at once again when it has ended. An interrupt before is answered by
Python's own start, with a traceback: so this module imports only what Python has loaded by then.
"""

import os
import sys

_signal = __import__("_signal")  # `signal` takes 5 ms to import, as it imports `enum`

INTERRUPTED = 130  # exit status, as shells report it


def leave(_number: int, _frame: object) -> None:
    """End the program at once: there is nothing to clean up yet."""
    os._exit(INTERRUPTED)


def main() -> None:
    """Run the command line."""
    try:
        from conf import cli

        cli.main()
    except KeyboardInterrupt:  # a second one, while the first was handled
        sys.exit(INTERRUPTED)
    finally:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


_signal.signal(_signal.SIGINT, leave)
if __name__ == "__main__":
    main()
