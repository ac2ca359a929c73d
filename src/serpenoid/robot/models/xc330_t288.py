"""XC330-T288-T: palm-size, metal gears, a three-cell battery; it measures what it draws.

Source: ROBOTIS e-manual, docs/en/dxl/x/xc330-t288.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current). Published input: 6.5 to 12.0 V. `voltage_range` is wider, as far as the servo's own limits (32, 34) go: three
full cells are 12.6 V.
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XC330-T288-T",
    number=1220,
    voltage_range=(5.5, 14.0),
    recommended_V=11.1,
    no_load_points=((9.0, 52.0), (11.1, 65.0), (12.0, 71.0)),
    effort=x_series.supply_current(910, 0.80),
    own=x_series.voltage_limits(55, 140) | x_series.series_330(320, pwm_slope=255),
    initial={
        "temperature_limit": 70,
        "velocity_i_gain": 1200,
        "velocity_p_gain": 40,
        "position_p_gain": 900,
    },
    baud_rates=x_series.BAUD_RATES_330,
)
