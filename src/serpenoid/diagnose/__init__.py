"""From measured trials to the cause of what the simulation gets wrong.

Three stages, top to bottom: commanded against realised shape (actuation), what markers and clocks report (observation),
realised shape against realised motion (medium). Effects found on the upper stages are taken out of the data before the
lower one is judged.
"""

from serpenoid.callable_room import make_callable

make_callable(__name__)
