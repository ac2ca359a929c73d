"""`python -m serpenoid` is `serpenoid`."""

from serpenoid.cli.main import entry

entry()
