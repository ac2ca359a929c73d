"""Print a script that lets the shell complete verbs, options and file names.

    serpenoid completion bash > ~/.local/share/bash-completion/completions/serpenoid
    serpenoid completion zsh > ~/.zfunc/_serpenoid      # with `fpath+=~/.zfunc; autoload -U compinit; compinit`
    serpenoid completion tcsh >> ~/.tcshrc

The script is static: completing starts no Python.
"""

from __future__ import annotations

import argparse
import sys

SHELLS = ("bash", "zsh", "tcsh")
FOLDERS = {"DIR", "FOLDER", "RESULTS", "DIAGNOSIS"}
FILES = {"FILE", "PROBLEM", "CAMPAIGN", "PROTOCOL", "PROTOCOL.toml", "PATH"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `completion`."""
    parser.add_argument("shell", choices=SHELLS, help="whose script")


def run(args: argparse.Namespace) -> int:
    """Print."""
    import shtab

    from serpenoid.cli.main import VERBS, build_parser

    parser = build_parser(*VERBS)
    _mark(parser)
    sys.stdout.write(shtab.complete(parser, args.shell) + "\n")
    return 0


def _mark(parser: argparse.ArgumentParser) -> None:
    """Say which arguments are files or folders, by what the help calls them."""
    import shtab

    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for sub in action.choices.values():
                _mark(sub)
        elif action.metavar in FOLDERS:
            action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
        elif action.metavar in FILES:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
