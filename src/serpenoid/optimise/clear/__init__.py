"""Keeping clear: of obstacles, and of the body itself."""
