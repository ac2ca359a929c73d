"""Print the schema of a problem file: every section and key, its type, default and meaning, as JSON Schema.

serpenoid schema
"""

from __future__ import annotations

import argparse
import json
import sys


def configure(_parser: argparse.ArgumentParser) -> None:
    """No arguments."""


def run(_args: argparse.Namespace) -> int:
    """Print."""
    from serpenoid.problem import Problem

    sys.stdout.write(json.dumps(Problem.model_json_schema(), indent=2) + "\n")
    return 0
