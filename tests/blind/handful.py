"""A fixed handful of strong hidden effects (S >= 6) for the normal test run, and one campaign with nothing hidden.

row = run_one(Study("handful", out, model), i)      # row["outcome"] must be "right"
"""

from __future__ import annotations

from blind.catalogue import Effect

HANDFUL_COMBINATIONS = 4  # gaits, each at one duration and heading, two trials of each: quick, and S stays above six
HANDFUL: tuple[tuple[Effect, ...], ...] = (
    (),
    (Effect("slope", None, {"pull_x": 0.0025, "pull_y": -0.0015}),),
    (Effect("zero_offset", 6, {"offset": 0.06}),),
    (Effect("servo_lag", None, {"lag": 0.04}),),
    (Effect("left_right_asymmetry", None, {"asymmetry": 0.2}),),
    (Effect("load", 2, {"share": 0.6}),),
    (Effect("dry_friction", None, {"crossover_speed": 0.3}),),
    (Effect("length_scale", None, {"error": -0.012}),),
)
