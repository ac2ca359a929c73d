"""The stages, top to bottom: actuation, observation, motion; each takes what was found out of the data."""
