"""XC330-M288-T: palm-size, metal gears; 5 V, it measures what it draws.

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
    effort=x_series.supply_current(2352, 1.80),
    own=x_series.voltage_limits_330() | x_series.series_330(350),
    initial={
        "temperature_limit": 70,
        "velocity_i_gain": 1600,
        "velocity_p_gain": 50,
        "position_d_gain": 500,
        "position_p_gain": 1100,
    },
    baud_rates=x_series.BAUD_RATES_330,
)
