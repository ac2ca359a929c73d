"""Trials of a campaign: what was commanded, read and seen, on one clock."""
