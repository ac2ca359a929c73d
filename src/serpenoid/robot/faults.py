"""What goes wrong while a robot is driven, as exceptions whose text says what happened and what to do."""


class RobotFault(RuntimeError):
    """The robot, its bus or its battery failed: the run ends with torque off and exit code 1."""


class BusFault(RobotFault):
    """A servo did not answer, or answered rubbish or an error; `servo_id` is None for the bus as a whole."""

    def __init__(self, message: str, servo_id: int | None = None) -> None:
        super().__init__(message)
        self.servo_id = servo_id


class PortLost(BusFault):
    """The serial port itself is gone (unplugged, or its driver failed)."""


class EmergencyStop(RobotFault):
    """The user pressed the emergency stop key."""
