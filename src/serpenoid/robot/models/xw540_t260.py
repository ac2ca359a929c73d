"""XW540-T260: waterproof, large and strong; it measures its current. It has no LED register.

Source: ROBOTIS e-manual, docs/en/dxl/x/xw540-t260.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XW540-T260",
    number=1170,
    voltage_range=(10.0, 14.8),
    recommended_V=12.0,
    no_load_points=((11.1, 37.0), (12.0, 40.0), (14.8, 48.0)),
    effort=x_series.current(0.00269, 2047, 4.9),
    own=x_series.voltage_limits(95, 160),
    initial={"velocity_limit": 167, "position_p_gain": 800},
    without=("led",),
)
