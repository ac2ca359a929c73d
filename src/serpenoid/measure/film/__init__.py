"""Tracks of a film as points that can be trusted: which marker is which, and which were never seen."""
