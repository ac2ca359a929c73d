"""XM430-W350: as large as an XL430, almost three times as strong; it measures its current.

-T and -R (RS-485) answer alike.

Source: ROBOTIS e-manual, docs/en/dxl/x/xm430-w350.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current). Its page says 110 to 300 for the voltage limits, around a factory value of 95; taken is 95 to 160,
as _includes/en/dxl/control_table_volt_limit_2.md says, which that page includes.
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XM430-W350",
    number=1020,
    voltage_range=(10.0, 14.8),
    recommended_V=12.0,
    no_load_points=((11.1, 43.0), (12.0, 46.0), (14.8, 57.0)),
    effort=x_series.current(0.00269, 1193, 2.3),
    own=x_series.voltage_limits(95, 160),
    initial={"velocity_limit": 200, "position_p_gain": 800},
)
