"""Pictures: functions (data, ax) -> ax, and composers that write PNG, SVG and GIF. The only import of matplotlib."""
