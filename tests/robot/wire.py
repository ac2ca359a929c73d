"""What a play puts on the bus, packet by packet: for comparison with what was put there before."""

from __future__ import annotations

from pathlib import Path

from emulated import emulator, gait, play_words, serpenoid

from serpenoid.robot.emulator import packets
from serpenoid.robot.table import write_table

ROBOT = """
format = 1
name = "two"
[bus]
baud_rate = 1000000
[motion]
cycle_duration_s = 0.8
[voltage]
minimum_V = 9.9
maximum_V = 12.6
[[joint]]
id = 1
sign = 1
zero_ticks = 2048
minimum_ticks = 1138
maximum_ticks = 2958
speed_limit_rpm = 40.0
[[joint]]
id = 2
sign = -1
zero_ticks = 2000
minimum_ticks = 1300
maximum_ticks = 2800
speed_limit_rpm = 57.0
"""


def recorded_play(folder: Path) -> tuple[list[str], list[str]]:
    """Packets in hexadecimal: those that are sent once, in order, and those that are repeated as time allows."""
    (folder / "two.toml").write_text(ROBOT)
    write_table(folder / "gait.csv", gait(joints=2))
    with emulator(folder) as rig:
        words = play_words(folder / "gait.csv", rig.port, folder / "log", cycles=2)
        words[words.index("--robot") + 1] = folder / "two.toml"
        done = serpenoid(*words)
        heard = rig.chain.heard
    assert done.returncode == 0, done.stderr
    sent: list[str] = []
    parser = packets.Parser()
    for packet in (packet for data in heard for packet in parser.feed(data)):
        whole = packets.build(packet.id, packet.instruction, packet.parameters).hex()
        sent.extend([whole] if sent[-1:] != [whole] else [])  # asked again: the computer was busy
    repeated = {raw for raw in sent if raw[14:16] == "82" or (raw[14:16] == "02" and raw[16:24] == "40002300")}
    return [raw for raw in sent if raw not in repeated], sorted(repeated)
