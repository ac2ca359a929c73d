"""MX-28 with firmware of Protocol 2.0 (MX-28(2.0); with Protocol 1.0 it does not answer); it tells its load.

Source: ROBOTIS e-manual, docs/en/dxl/mx/mx-28-2.md (control table; Velocity Limit 230),
_data/dxl_mx_info.yml (voltage, speeds, stall current) and _includes/en/dxl/control_table_volt_limit_mx.md (95 to 160),
control_table_vellimit.md (0 to 1023).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="MX-28-2.0",
    number=30,
    voltage_range=(10.0, 14.8),
    recommended_V=12.0,
    no_load_points=((11.1, 50.0), (12.0, 55.0), (14.8, 67.0)),
    effort=x_series.load(),
    own=x_series.mx_series(),
    initial={"velocity_limit": 230, "position_p_gain": 850},
    without=x_series.MX_LACKS,
)
