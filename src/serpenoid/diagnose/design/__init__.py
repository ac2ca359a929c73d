"""The next experiment: which gait would tell rivals apart."""
