"""XC430-W150: as large as an XL430, metal gears; it tells its load. Its variants (-T, BB) answer alike.

Source: ROBOTIS e-manual, docs/en/dxl/x/xc430-w150.md (control table) and _data/dxl_x_info.yml (voltage, speeds).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XC430-W150",
    number=1070,
    voltage_range=(6.5, 14.8),
    recommended_V=12.0,
    no_load_points=((9.0, 80.0), (11.1, 99.0), (12.0, 106.0)),
    effort=x_series.load(),
    own=x_series.voltage_limits(60, 160),
    initial={"moving_threshold": 20, "velocity_limit": 460, "position_p_gain": 460},
)
