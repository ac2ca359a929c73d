"""XW540-T140: waterproof, large and fast; it measures its current. It has no LED register.

Source: ROBOTIS e-manual, docs/en/dxl/x/xw540-t140.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XW540-T140",
    number=1180,
    voltage_range=(10.0, 14.8),
    recommended_V=12.0,
    no_load_points=((11.1, 67.0), (12.0, 72.0), (14.8, 88.0)),
    effort=x_series.current(0.00269, 2047, 4.9),
    own=x_series.voltage_limits(95, 160),
    initial={"velocity_limit": 304, "position_p_gain": 800},
    without=("led",),
)
