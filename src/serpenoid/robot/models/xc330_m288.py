"""XC330-M288-T: palm-size, metal gears; 5 V, it measures its current.

Source: ROBOTIS e-manual, docs/en/dxl/x/xc330-m288.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current).
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XC330-M288-T",
    number=1240,
    voltage_range=(3.7, 6.0),
    recommended_V=5.0,
    no_load_points=((3.7, 59.0), (5.0, 81.0), (6.0, 97.0)),
    effort=x_series.current(0.001, 2352, 1.80),
    own=x_series.voltage_limits_330()
    | x_series.pwm_slope()
    | {
        "baud_rate": x_series.writable(8, 1, 1, 0, 6),
        "protocol_type": x_series.writable(13, 1, 2, 2, 22),
        "velocity_limit": x_series.writable(44, 4, 350, 0, 2047),
        "goal_velocity": x_series.writable(104, 4, 0, -2047, 2047),
    },
    initial={
        "temperature_limit": 70,
        "velocity_i_gain": 1600,
        "velocity_p_gain": 50,
        "position_d_gain": 500,
        "position_p_gain": 1100,
    },
    baud_rates=x_series.BAUD_RATES_330,
)
