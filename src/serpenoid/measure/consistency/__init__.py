"""Does a campaign agree with itself? Hypotheses about its contract, scored against what was measured.

A campaign file promises which table was played, how fast, by which joints, and which marker is which vertex. Each
promise has rivals (another table, the same one backwards, a sign flipped, another cycle duration, two markers
exchanged). All are scored alike: by the log evidence of the measured shapes under the promise, with what physics may do
to it set free (servos that are late, slow, weak, stuck or wrongly zeroed). A rival ahead by `ODDS` is a contradiction.

Read in this order: `signals` (angles over time), `match` (one hypothesis laid over one signal), `servos` (the same as
late or slow servos play it), `claim` (what a trial promises, and who witnesses it), `hypotheses` (the rivals), `rivals`
(all of them beside the contract), `geometry` (the same for markers on rigid links, wherever they sit: `reach` is how
far apart a body allows them, `layout` how well they keep to it), `exchanged` (names that a tracker exchanges for a
while), `fallen` (markers that fell off), `leaps` (bodies that move by many lengths in a frame), `lengths` (one body in
all trials), `clock_steps` (of a log), `check` (a trial, then a campaign), `claims` (a folder).
"""
