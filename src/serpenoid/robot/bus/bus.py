"""The servo bus through ROBOTIS's SDK: every exchange is checked, every failure is a `BusFault` with a name.

The SDK's GroupSyncRead gives nothing when one servo fails and drops the alert bit, so sync reads are sent by the SDK's
packet handler and their answers collected here, one by one.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Self, TypeVar

import dynamixel_sdk as sdk

from serpenoid.robot.bus.collisions import Found, read_ping_answers
from serpenoid.robot.bus.link import PORT_ERRORS, SerialLink, said
from serpenoid.robot.bus.readings import Answer, ServoHealth, ServoState, decode, decode_health, decode_state
from serpenoid.robot.faults import BusFault, PortLost
from serpenoid.robot.models import DEFAULT, Block, Register, ServoModel, by_number, models
from serpenoid.robot.port import not_opened

ALERT_BIT = 0x80
ATTEMPTS_AT_REST = 6  # nothing moves: a slow answer is worth waiting for
ATTEMPTS_IN_MOTION = 5  # 0.2 s: the watchdogs must not be the first to notice
NO_ANSWER = "no answer"

T = TypeVar("T")


class Bus:
    """An open port; close it, or use `with`.

    servos: each one's model by its ID, with all that is `Shared` alike (`Robot` sees to that); `scan` adds those that
    it knows. A servo whose model nobody says is spoken to as the usual one.
    """

    def __init__(self, port_name: str, baud_rate: int, servos: Mapping[int, ServoModel]) -> None:
        self._servos = dict(servos)
        self._link = SerialLink(port_name)
        self._packets = sdk.Protocol2PacketHandler()
        self.attempts = ATTEMPTS_AT_REST
        self.failures: Counter[int] = Counter()  # by servo ID; each was repeated
        with self._guard("opening"):
            if not self._link.setBaudRate(baud_rate):
                raise BusFault(f"{port_name}: this computer cannot do {baud_rate} baud.")
        self._shared = next(iter(self._servos.values()), models()[DEFAULT]).shared
        goal = self._shared.goal
        self._goals = sdk.GroupSyncWrite(self._link, self._packets, goal.address, goal.size)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        try:
            self._link.closePort()
        except PORT_ERRORS:
            self._link.is_open = False

    def scan(self) -> Found:
        """Broadcast ping. The SDK throws away what it cannot read, so all that was heard is read here."""
        with self._guard("broadcast ping"), contextlib.suppress(IndexError, TypeError, ValueError):
            self._packets.broadcastPing(self._link)
        found = read_ping_answers(bytes(self._link.heard), lambda data: self._packets.updateCRC(0, data, len(data)))
        known = {servo_id: by_number(number) for servo_id, (number, _) in found.servos.items()}
        self._servos |= {servo_id: servo for servo_id, servo in known.items() if servo is not None}
        return found

    def model(self, servo_id: int) -> ServoModel:
        """What is known of a servo, else the usual model."""
        return self._servos.get(servo_id, models()[DEFAULT])

    def _register(self, servo_id: int, name: str) -> Register:
        return self.model(servo_id).registers[name]

    def is_garbled(self, servo_id: int) -> bool:
        """Whether what comes back from an ID is no whole answer; a single question, so noise may look like it."""
        with self._guard("read", servo_id):
            self._packets.readTx(self._link, servo_id, self._shared.state.address, self._shared.state.size)
            return self._receive(self._shared.state.size).reason not in ("", NO_ANSWER)

    def ping(self, servo_id: int) -> int:
        """The model number."""
        return self._retry(lambda: self._checked(servo_id, "ping", self._packets.ping(self._link, servo_id)))

    def read(self, servo_id: int, register: str) -> int:
        item = self._register(servo_id, register)
        data = self._retry(lambda: self._read_once(servo_id, Block(item.address, item.size)).data)
        return decode(data, item)

    def write(self, servo_id: int, register: str, value: int) -> None:
        """Write and wait for the servo's own word that it took the value."""
        item = self._register(servo_id, register)
        data = list((value & (1 << 8 * item.size) - 1).to_bytes(item.size, "little"))

        def once() -> None:
            answer = self._packets.writeTxRx(self._link, servo_id, item.address, item.size, data)
            self._checked(servo_id, f"writing {register} = {value}", (None, *answer))

        self._retry(once)

    def reboot(self, servo_id: int) -> None:
        self._retry(lambda: self._checked(servo_id, "reboot", (None, *self._packets.reboot(self._link, servo_id))))

    def write_goals(self, goals: Mapping[int, int]) -> None:
        """One sync write of goal positions [ticks]; sync writes get no answer, so limits are checked before."""
        self._goals.clearParam()
        for servo_id, ticks in goals.items():
            self._goals.addParam(servo_id, list(int(ticks).to_bytes(self._shared.goal.size, "little", signed=True)))
        with self._guard("sync write"):
            result = self._goals.txPacket()
        if result != sdk.COMM_SUCCESS:
            raise PortLost(f"a row could not be sent ({self._packets.getTxRxResult(result)}).")

    def read_states(self, servo_ids: Sequence[int]) -> dict[int, ServoState]:
        """One sync read; servos whose answer is missing or corrupt are asked again by themselves."""
        states = dict(self._sync_read(servo_ids))
        for servo_id in servo_ids:
            if servo_id not in states:
                self.failures[servo_id] += 1
                states[servo_id] = self._retry(lambda i=servo_id: self._read_state(i))  # type: ignore[misc]
        return states

    def read_health(self, servo_id: int) -> ServoHealth:
        """Torque, hardware error and watchdog of one servo, in one exchange."""
        servo = self.model(servo_id)
        return decode_health(self._retry(lambda: self._read_once(servo_id, servo.health)).data, servo)

    def torque_off(self, servo_ids: Iterable[int]) -> list[int]:
        """Switch every motor off, all at once and then one by one; return the IDs that did not confirm."""
        torque = self._shared.torque
        self.attempts = ATTEMPTS_AT_REST
        for _ in range(2):
            with self._guard("torque off"):
                self._packets.writeTxOnly(self._link, sdk.BROADCAST_ID, torque.address, torque.size, [0])
        return [servo_id for servo_id in servo_ids if not self._confirm_torque_off(servo_id)]

    def _confirm_torque_off(self, servo_id: int) -> bool:
        try:
            self.write(servo_id, "torque_enable", 0)
        except PortLost:
            raise
        except BusFault:
            return False
        return True

    def _sync_read(self, servo_ids: Sequence[int]) -> Iterator[tuple[int, ServoState]]:
        """Servos answer in the order asked; one out of turn is a late answer to an earlier question, and old."""
        with self._guard("sync read"):
            ids = list(servo_ids)
            self._packets.syncReadTx(
                self._link, self._shared.state.address, self._shared.state.size, ids, len(ids), False
            )
            waiting = list(ids)
            while waiting:
                answer = self._receive(self._shared.state.size)
                if answer.reason == NO_ANSWER:
                    return
                if answer.servo_id in (waiting[0], None):
                    servo_id = waiting.pop(0)
                    if not answer.reason:
                        yield servo_id, decode_state(answer.data, answer.alert, self.model(servo_id))

    def _read_state(self, servo_id: int) -> ServoState:
        answer = self._read_once(servo_id, self._shared.state)
        return decode_state(answer.data, answer.alert, self.model(servo_id))

    def _read_once(self, servo_id: int, block: Block) -> Answer:
        with self._guard("read", servo_id):
            self._packets.readTx(self._link, servo_id, block.address, block.size)
            answer = self._receive(block.size)
            while answer.servo_id not in (servo_id, None):  # a late answer to an earlier question
                answer = self._receive(block.size)
        if answer.reason:
            raise BusFault(f"servo {servo_id}: {answer.reason}.", servo_id)
        return answer

    def _receive(self, size: int) -> Answer:
        """The next status packet; one that does not carry exactly `size` bytes of data has a `reason`."""
        packet, result = self._packets.rxPacket(self._link, False)
        if result != sdk.COMM_SUCCESS:
            return Answer(None, reason=_reason(result))
        servo_id, error = packet[4], packet[8]
        if error & ~ALERT_BIT:
            return Answer(servo_id, reason=self._packets.getRxPacketError(error))
        if packet[5] | packet[6] << 8 != size + 4:
            return Answer(servo_id, reason="an answer of the wrong length")
        return Answer(servo_id, bytes(packet[9 : 9 + size]), bool(error & ALERT_BIT))

    def _checked(self, servo_id: int, doing: str, answer: tuple[Any, int, int]) -> Any:
        value, result, error = answer
        if result != sdk.COMM_SUCCESS:
            raise BusFault(f"servo {servo_id}: {_reason(result)} to {doing}.", servo_id)
        if error & ~ALERT_BIT:
            raise BusFault(f"servo {servo_id} refused {doing}: {self._packets.getRxPacketError(error)}", servo_id)
        return value

    def _retry(self, exchange: Callable[[], T]) -> T:
        for _ in range(self.attempts - 1):
            try:
                with self._guard("exchange"):
                    return exchange()
            except PortLost:
                raise
            except BusFault as fault:
                if fault.servo_id is not None:
                    self.failures[fault.servo_id] += 1
        with self._guard("exchange"):
            return exchange()

    @contextmanager
    def _guard(self, doing: str, servo_id: int | None = None) -> Iterator[None]:
        """Turn what pyserial and the SDK raise into faults, and leave the port ready for the torque-off."""
        try:
            yield
        except PORT_ERRORS as error:
            message = f"{self._link.port_name}: the port is lost while {doing} ({said(error)})."
            raise PortLost(message, servo_id) from error
        except (IndexError, TypeError, ValueError) as error:  # the SDK indexes into packets that are too short
            raise BusFault(f"corrupt answer while {doing} ({error}).", servo_id) from error
        finally:
            self._link.is_using = False


def _reason(result: int) -> str:
    return NO_ANSWER if result == sdk.COMM_RX_TIMEOUT else "a corrupt answer (its checksum or length is wrong)"


def open_bus(port_name: str, baud_rate: int, servos: Mapping[int, ServoModel]) -> Bus:
    """A Bus on a port that the user named: what cannot be opened is bad input."""
    try:
        return Bus(port_name, baud_rate, servos)
    except BusFault as fault:
        raise not_opened(f"--port {port_name}", fault.__cause__ or fault) from None
