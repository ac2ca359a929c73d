"""XL430-W250-T: plastic, a three-cell battery; it tells its load.

Source: ROBOTIS e-manual, docs/en/dxl/x/xl430-w250.md (control table) and _data/dxl_x_info.yml (voltage, speeds).
Published input: 6.5 to 12.0 V. `voltage_range` is wider, as far as the servo's own limits (32, 34) go: three full
lithium cells are 12.6 V.
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XL430-W250-T",
    number=1060,
    voltage_range=(6.0, 14.0),
    recommended_V=11.1,
    no_load_points=((9.0, 47.0), (11.1, 57.0), (12.0, 61.0)),
    effort=x_series.load(),
    own=x_series.voltage_limits(60, 140) | {"drive_mode": x_series.writable(10, 1, 0, 0, 13)},
    initial={
        "temperature_limit": 72,
        "velocity_limit": 265,
        "velocity_i_gain": 1000,
        "position_d_gain": 4000,
        "position_p_gain": 640,
        "present_input_voltage": 118,  # three cells at rest
    },
)
