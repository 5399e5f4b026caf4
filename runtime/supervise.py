"""Runs the command in its arguments, as the head of a process group that ends with the process that started it.

Its standard input is a pipe without data.  The pipe closes when the starter ends for any reason, and then
every process of the group is killed.  Exit code: the command's, or 128 and the signal that ended it.
"""

from __future__ import annotations

import os
import signal
import sys
from _thread import start_new_thread


def main(command: list[str]) -> int:
    """Run ``command`` and return its exit code."""
    start_new_thread(_watch, ())
    nothing = (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0)
    try:
        child = os.posix_spawnp(command[0], command, os.environ, file_actions=[nothing])
    except OSError as error:
        print(f"{command[0]}: {error.strerror}", file=sys.stderr)
        return 127
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return code if code >= 0 else 128 - code


def _watch() -> None:
    while os.read(0, 1):
        pass
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
