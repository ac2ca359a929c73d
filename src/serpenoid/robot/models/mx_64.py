"""MX-64 with firmware of Protocol 2.0 (MX-64(2.0); with Protocol 1.0 it does not answer); it measures its current.

Source: ROBOTIS e-manual, docs/en/dxl/mx/mx-64-2.md (control table; Velocity Limit 435, which firmware 42 lowered
to a number that could not be verified),
_data/dxl_mx_info.yml (voltage, speeds, stall current) and _includes/en/dxl/control_table_volt_limit_mx.md (95 to 160),
control_table_vellimit.md (0 to 1023).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="MX-64-2.0",
    number=311,
    voltage_range=(10.0, 14.8),
    recommended_V=12.0,
    no_load_points=((11.1, 58.0), (12.0, 63.0), (14.8, 78.0)),
    effort=x_series.current(0.00336, 1941, 4.1),
    own=x_series.mx_series(),
    initial={"velocity_limit": 435, "position_p_gain": 850},
    without=x_series.MX_LACKS,
)
