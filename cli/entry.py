"""Entry point of the command ``tfra``: failures of streams or imports end it with one line.

Only modules that Python has already loaded are imported here, so that Ctrl-C is handled from the start.  It kills
the process while the command line is imported, and raises ``KeyboardInterrupt`` afterwards.

Exit codes in addition to those of :mod:`tfra.cli.main`: 1 if output can't be written or the system fails otherwise,
70 for a bug, 130 after Ctrl-C, 141 if the reader of standard output is gone.
"""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import warnings
from contextlib import suppress

from tfra.cli.messages import print_error

TYPE_CHECKING = False  # importing typing takes milliseconds
if TYPE_CHECKING:
    from sys import UnraisableHookArgs

    from _typeshed import ReadableBuffer

BUG = 70
"""``EX_SOFTWARE`` of sysexits.h."""


class _Output(io.FileIO):
    """A standard stream that keeps its last write error, even if the exception is swallowed."""

    error: OSError | None = None

    def write(self, data: ReadableBuffer, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            self.error = error
            raise


def main() -> int:
    """Run the command line on the process's own streams and return its exit code."""
    _open_closed_streams()
    output, complaints = _Output(1, "wb", closefd=False), _Output(2, "wb", closefd=False)
    try:
        sys.stdout, sys.stderr = _text(output, sys.stdout), _text(complaints, sys.stderr)
        code = _finished(_run(output, complaints), output)
    except KeyboardInterrupt:
        code = 130
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # nothing is left to interrupt
    for descriptor, stream in ((1, output), (2, complaints)):
        if stream.error is not None:  # what waits in its buffer goes nowhere
            os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
    return code


def _run(output: _Output, complaints: _Output) -> int:
    try:
        warnings.resetwarnings()  # whatever PYTHONWARNINGS says; the command line then enables its own
        warnings.simplefilter("ignore")
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing to clean up yet
        from tfra.cli.main import main as run

        signal.signal(signal.SIGALRM, signal.default_int_handler)
        sys.unraisablehook = _interrupt_again
        signal.signal(signal.SIGINT, signal.default_int_handler)
        return run()
    except OSError as error:
        if output.error is None and complaints.error is None:
            print_error(f"tfra: {f'{error.filename}: ' if error.filename else ''}{error.strerror or error}")
        return 1
    except SystemExit:  # how rich and typer answer a broken pipe
        return 1
    except Exception:
        import traceback

        print_error(f"{traceback.format_exc()}tfra: this is a bug in tfra; please report it with the lines above")
        return BUG


def _finished(code: int, output: _Output) -> int:
    """Flush standard output, and return the exit code."""
    with suppress(OSError):
        sys.stdout.flush()
    if output.error is None:
        return code
    if output.error.errno == errno.EPIPE:
        return 128 + signal.SIGPIPE
    print_error(f"standard output: cannot be written: {output.error.strerror}")
    return code or 1


def _interrupt_again(ignored: UnraisableHookArgs) -> None:
    """Raise a Ctrl-C again that Python dropped because it came in a callback, for instance in an import."""
    if ignored.exc_type is KeyboardInterrupt:
        signal.setitimer(signal.ITIMER_REAL, 0.01)
    else:
        sys.__unraisablehook__(ignored)


def _open_closed_streams() -> None:
    """Occupy closed descriptors, so that no file opened later becomes standard output.

    Standard output is opened read-only, so that writing fails as it should.
    """
    for descriptor, mode in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(descriptor)
        except OSError:
            os.set_inheritable(os.open(os.devnull, mode), True)


def _text(raw: _Output, former: object) -> io.TextIOWrapper:
    """Return ``raw`` as text; characters that its encoding lacks are escaped."""
    encoding = getattr(former, "encoding", None) or "utf-8"
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding, "backslashreplace", line_buffering=True)
