"""The robot on its bus: find servos, check a gait, rehearse without hardware, switch everything off.

serpenoid robot scan                                          which servos answer, at which baud rate
serpenoid robot check RESULTS --robot FILE                    would this gait be refused, and why
serpenoid robot check RESULTS --robot FILE --port auto        the same, with voltage and shape as measured
serpenoid robot emulate                                       ten emulated servos on a port of their own
serpenoid robot off --robot FILE                              torque off, whatever was going on
serpenoid robot reboot --robot FILE                           clear hardware errors after their cause is gone
serpenoid robot power --port PORT --log DIR                   record an INA260 stream without playing
"""

from __future__ import annotations

import argparse

from serpenoid.cli import robot_bus, robot_emulate


def configure(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    robot_bus.configure(actions)
    robot_emulate.configure(actions)


def run(args: argparse.Namespace) -> int:
    return args.do(args)
