"""Angles and poses of a body from its points and its servos."""
