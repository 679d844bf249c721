"""The command ``contactqp``: it answers Ctrl-C from its first moment on, and then loads the command line.

It stands beside the package, because importing anything from that loads numpy and more first, which takes half a
second; an interrupt that hits an import gives a traceback, or is taken for a damaged library. While nothing is written
yet the process can simply end. What ends a command at work is
`contactqp.foundation.interrupts.ended_by_interrupts`. The last moments are the interpreter's, which takes its handlers
down before it ends: a signal would kill it then, and the exit code deny what was done, so there it is ignored.
"""

import atexit
import os
import sys
from types import FrameType
from typing import NoReturn

INTERRUPTED, WORDS = 130, "contactqp: interrupted\n"
"""Exit code and words of an interrupted command, the same as when it is at work."""


def main() -> None:
    """Run the command line."""
    try:
        import signal

        signal.signal(signal.SIGINT, _end)
        # Registered first, and so called last.
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    except KeyboardInterrupt:
        _end()
    from contactqp.cli.commands import main as run

    run()


def _end(number: int = 0, frame: FrameType | None = None) -> NoReturn:
    try:
        sys.stdout.flush()
        sys.stderr.write(WORDS)
        sys.stderr.flush()
    except Exception:  # a stream may be missing, closed, or just being written to
        pass
    os._exit(INTERRUPTED)
