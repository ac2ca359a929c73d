"""Copy the examples that come with the package: problem files, robots, protocols, campaigns, Python programs.

    serpenoid examples                  # into ./problems, where every other --help expects them
    serpenoid examples elsewhere
    serpenoid examples --list

Files that are there already are kept as they are.
"""

from __future__ import annotations

import argparse
import shlex
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from serpenoid.cli import options
from serpenoid.wording import counted


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `examples`."""
    parser.add_argument("folder", nargs="?", default="problems", metavar="DIR", help="where to (default: ./problems)")
    parser.add_argument("--list", action="store_true", help="name the files, copy nothing")


def run(args: argparse.Namespace) -> int:
    """Copy, say what."""
    from serpenoid.files.writing import examples

    names, source, folder = list(_files(examples())), examples(), Path(args.folder)
    if args.list:
        sys.stdout.write("\n".join(name.as_posix() for name in names) + "\n")
        return 0
    options.check_writable(folder)
    new = [name for name in names if not (folder / name).exists()]
    for name in new:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source / name, folder / name)
    kept = f", {len(names) - len(new)} were there already" if len(new) < len(names) else ""
    first = f"serpenoid solve {shlex.quote(f'{folder}/snake10.toml')}"
    sys.stdout.write(f"{counted(len(new), 'file')} copied to {folder}{kept}. Begin: {first}\n")
    return 0


def _files(source: Path) -> Iterator[Path]:
    for path in sorted(source.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            yield path.relative_to(source)
