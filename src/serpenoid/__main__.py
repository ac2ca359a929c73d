"""The console script `serpenoid`, and `python -m serpenoid`: one exit code, whenever Ctrl-C comes."""

import ctypes
import gc
import os
import signal
import sys
from contextlib import suppress

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # of linear algebra
NEW_OBJECTS = 100_000  # until Python looks for garbage among them
TRIM, TOP_PAD, MMAP = -1, -2, -3  # names of the GNU C library's mallopt
KEPT_BYTES, LARGE_BYTES = 2**30, 2**25  # free memory kept for what comes next; what is asked of the system at once


def calm() -> None:
    """One thread of linear algebra in each process: on matrices as small as ours more of them wait for one another,
    which takes a third of a diagnosis' processor time. Whoever has set a number keeps it.

    Pictures are written and no window is opened: the backend of a notebook or a profile is of no use here, and one that
    is not installed would end a command after its work.

    Memory that was freed is kept for what comes next, and garbage is looked for less often: a page that the system
    gives anew, or that is touched in a process that has forked others, costs more than what is done in it.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")
    os.environ["MPLBACKEND"] = "agg"
    gc.set_threshold(NEW_OBJECTS)
    with suppress(AttributeError, OSError, TypeError):  # another C library
        mallopt = ctypes.CDLL(None).mallopt
        for option, value in ((TRIM, KEPT_BYTES), (TOP_PAD, LARGE_BYTES), (MMAP, LARGE_BYTES)):
            mallopt(option, value)


def entry() -> None:
    """Run one command. While modules are imported nothing has begun, and Ctrl-C ends the process without a word."""
    usual = signal.getsignal(signal.SIGINT)
    heard = usual is signal.default_int_handler
    if heard:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    calm()
    from serpenoid.cli.main import main, stopped

    if heard:
        signal.signal(signal.SIGINT, usual)
    try:
        code = main()
    except KeyboardInterrupt:  # before the command was begun
        code = stopped()
    if heard:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # or Ctrl-C as Python ends changes the exit code
    gc.freeze()  # or Python looks through all that libraries have made, a fifth of a second long, before it ends
    exec("")  # forgets a Ctrl-C that came as a dataclass was made: Python would send it to itself once more as it ends
    sys.exit(code)


if __name__ == "__main__":
    entry()
