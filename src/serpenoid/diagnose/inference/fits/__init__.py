"""Exact fits, what they leave, and what an explanation must be worth."""
