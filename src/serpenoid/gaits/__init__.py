"""Gaits: closed curves in shape space, and joint tables."""

from serpenoid.gaits.ellipse import EllipseGait
from serpenoid.gaits.table import TableGait

__all__ = ["EllipseGait", "TableGait"]
