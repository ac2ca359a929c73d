"""XM430-W210: as large as an XL430, twice as strong; it measures its current.

-T and -R (RS-485) answer alike.

Source: ROBOTIS e-manual, docs/en/dxl/x/xm430-w210.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XM430-W210",
    number=1030,
    voltage_range=(10.0, 14.8),
    recommended_V=12.0,
    no_load_points=((11.1, 70.0), (12.0, 77.0), (14.8, 95.0)),
    effort=x_series.current(0.00269, 1193, 2.3),
    own=x_series.voltage_limits(95, 160),
    initial={"velocity_limit": 330, "position_p_gain": 800},
)
