"""The cache folder: where it lies, and what is said, once, where it cannot be written."""

from __future__ import annotations

import logging
import multiprocessing
import os
from functools import lru_cache
from pathlib import Path

import platformdirs

VARIABLE = "SERPENOID_CACHE"
log = logging.getLogger(__name__)


def place() -> Path:
    """`SERPENOID_CACHE`, else the user's cache."""
    return Path(os.environ.get(VARIABLE) or platformdirs.user_cache_dir("serpenoid"))


def lost(error: Exception) -> bool:
    """Whether something could not be kept because nothing can be; the first time that is a warning, but not in workers,
    which meet what the first process meets."""
    folder = place()
    if not isinstance(error, OSError) or (folder.is_dir() and os.access(folder, os.W_OK)):
        return False
    if multiprocessing.current_process().name == "MainProcess":
        _say(folder)
    return True


@lru_cache
def _say(folder: Path) -> None:
    named = f"{VARIABLE} = {folder}" if os.environ.get(VARIABLE) else f"the cache folder {folder}"
    log.warning(
        "%s cannot be written to: nothing is compiled or kept, so CasADi's virtual machine takes longer, for the "
        "same results, and an interrupted command begins again. Set %s to a folder of your own.",
        named, VARIABLE,
    )  # fmt: skip
