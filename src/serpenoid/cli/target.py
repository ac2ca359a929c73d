"""Where a command writes, as it was named on the command line."""

from __future__ import annotations

import argparse
from pathlib import Path


def target(text: str) -> Path:
    """A folder or file to write; nothing is no name: a shell makes nothing of a variable that is not set, and what is
    then written where nobody looks for it is as good as lost."""
    if not text.strip():
        raise argparse.ArgumentTypeError(
            "names nothing. Name where to write (`.` is this folder). Is a variable of the shell not set?"
        )
    return Path(text)
