"""Start of the program, for `conf` and `python -m conf`.

Ctrl-C ends a program at any time without a traceback: at once while the modules are imported, through KeyboardInterrupt
while a command runs, and at once again when it has ended.
"""

import os
import signal
import sys
from types import FrameType

INTERRUPTED = 130  # exit status, as shells report it


def leave(_number: int, _frame: FrameType | None) -> None:
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
        signal.signal(signal.SIGINT, signal.SIG_DFL)


signal.signal(signal.SIGINT, leave)
if __name__ == "__main__":
    main()
