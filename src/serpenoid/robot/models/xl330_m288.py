"""XL330-M288-T: palm-size; 5 V, it measures what it draws.

Source: ROBOTIS e-manual, docs/en/dxl/x/xl330-m288.md (control table) and _data/dxl_x_info.yml (voltage, speeds, stall
current). Its watchdog is said to need no firmware (control_table_buswatchdog.md), so none is too old.
"""

from serpenoid.robot.models import x_series

MODEL = x_series.servo(
    name="XL330-M288-T",
    number=1200,
    voltage_range=(3.7, 6.0),
    recommended_V=5.0,
    no_load_points=((3.7, 76.0), (5.0, 103.0), (6.0, 123.0)),
    effort=x_series.supply_current(1750, 1.47),
    own=x_series.voltage_limits_330() | x_series.series_330(445),
    initial={
        "temperature_limit": 70,
        "shutdown": 53,
        "velocity_i_gain": 1600,
        "velocity_p_gain": 180,
        "position_p_gain": 400,
    },
    oldest_firmware=0,
    baud_rates=x_series.BAUD_RATES_330,
)
