"""XM540-W270: large and strong, for the middle of a long snake; it measures its current.

-T and -R (RS-485) answer alike.

Source: ROBOTIS e-manual, docs/en/dxl/x/xm540-w270.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current). Its external ports' data (152 to 157), of which nothing here makes use, are left out.
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XM540-W270",
    number=1120,
    voltage_range=(10.0, 14.8),
    recommended_V=12.0,
    no_load_points=((11.1, 28.0), (12.0, 30.0), (14.8, 37.0)),
    effort=x_series.current(0.00269, 2047, 4.4),
    own=x_series.voltage_limits(95, 160)
    | {
        "external_port_mode_1": x_series.writable(56, 1, 3, 0, 3),
        "external_port_mode_2": x_series.writable(57, 1, 3, 0, 3),
        "external_port_mode_3": x_series.writable(58, 1, 3, 0, 3),
    },
    initial={"velocity_limit": 128, "position_p_gain": 800},
)
