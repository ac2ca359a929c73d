"""Which effects explain the windows: exact fits, priors, evidence, search, groups."""
