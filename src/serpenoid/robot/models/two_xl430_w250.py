"""2XL430-W250-T: two axes in one case, each of them a servo with its own ID; it tells its load.

Source: ROBOTIS e-manual, docs/en/dxl/x/2xl430-w250.md (control table) and _data/dxl_x_info.yml (voltage, speeds).
Published input: 6.5 to 12.0 V; `voltage_range` is that of the XL430-W250-T, whose limits (32, 34) it has.
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="2XL430-W250-T",
    number=1090,
    voltage_range=(6.0, 14.0),
    recommended_V=11.1,
    no_load_points=((9.0, 47.0), (11.1, 57.0), (12.0, 61.0)),
    effort=x_series.load(),
    own=x_series.voltage_limits(60, 140) | {"drive_mode": x_series.writable(10, 1, 0, 0, 1)},
    initial={
        "temperature_limit": 72,
        "velocity_limit": 250,
        "velocity_i_gain": 1800,
        "position_d_gain": 2000,
        "position_p_gain": 640,
    },
    without=("startup_configuration", "backup_ready"),
)
