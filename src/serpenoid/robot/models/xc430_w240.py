"""XC430-W240: as large as an XL430, metal gears; it tells its load. Its variants (-T, BB) answer alike.

Source: ROBOTIS e-manual, docs/en/dxl/x/xc430-w240.md (control table) and _data/dxl_x_info.yml (voltage, speeds).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XC430-W240",
    number=1080,
    voltage_range=(6.5, 14.8),
    recommended_V=12.0,
    no_load_points=((9.0, 52.0), (11.1, 65.0), (12.0, 70.0)),
    effort=x_series.load(),
    own=x_series.voltage_limits(60, 160) | {"drive_mode": x_series.writable(10, 1, 0, 0, 13)},
    initial={"velocity_limit": 306, "position_p_gain": 700},
)
