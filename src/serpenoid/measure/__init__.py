"""Recordings: files of trackers, servos and batteries become aligned, frozen trials.

Read in this order: `campaign` (what the folder promises), `cells`, `motive`, `points`, `logs` (files to values),
`relabel` (which marker is which vertex), `chain` (shape and pose with uncertainty), `clock`, `schedule`, `quality`,
`trial` (all of it put together).
"""

from serpenoid.callable_room import make_callable

make_callable(__name__)
