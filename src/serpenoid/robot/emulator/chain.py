"""Servos on one bus: bytes in, timed bytes out. Pure: time is an argument, so tests need no clock."""

from __future__ import annotations

import random
from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Protocol

from serpenoid.robot.emulator import packets
from serpenoid.robot.emulator.collision import overlapped
from serpenoid.robot.emulator.faults import Fault
from serpenoid.robot.emulator.servo import EmulatedServo

BITS_PER_BYTE = 10  # start, eight data, stop
Servos = dict[int, list[EmulatedServo]]  # by ID
SILENCE_S = 0.05  # a packet that pauses this long inside is given up


class Ground(Protocol):
    """What the servos are built into, if more than free shafts."""

    def advance(self, now: float) -> None:
        """Move up to time `now` [s]."""


@dataclass(frozen=True)
class Reply:
    """Bytes that have arrived completely at the master at time `due` [s]."""

    due: float
    data: bytes


class Chain:
    """The emulated bus; `baud_rate` sets how long bytes take."""

    def __init__(
        self, servos: Sequence[EmulatedServo], baud_rate: int, faults: Sequence[Fault] = (), seed: int = 0
    ) -> None:
        self.servos = list(servos)
        self.faults = list(faults)
        self.ground: Ground | None = None
        self.instructions = 0
        self.parser = packets.Parser()
        self.torque_since: float | None = None
        self._spent: set[Fault] = set()  # faults that happen once
        self._byte_s = BITS_PER_BYTE / baud_rate
        self._free_at = 0.0
        self._last_byte = 0.0
        self._random = random.Random(seed)

    def elapsed(self, now: float) -> float | None:
        return None if self.torque_since is None else now - self.torque_since

    def advance(self, now: float) -> None:
        for fault in self.faults:
            if fault.active(self.elapsed(now)):
                self._apply(fault)
        if self.ground is not None:
            self.ground.advance(now)
        for servo in self.servos:
            servo.advance(now)

    def receive(self, data: bytes, now: float) -> list[Reply]:
        """Bytes that the master wrote at `now`; replies in the order in which they arrive."""
        if now - self._last_byte > SILENCE_S:
            self.parser.forget_partial()
        self._last_byte = now
        self._free_at = max(self._free_at, now) + len(data) * self._byte_s
        replies: list[Reply] = []
        for packet in self.parser.feed(data):
            replies += self._dispatch(packet, self._free_at)
        return replies

    def _dispatch(self, packet: packets.Packet, now: float) -> list[Reply]:
        self.instructions += 1
        self.advance(now)
        listening = [servo for servo in self.servos if not self._has("deaf", servo, now)]
        for servo in listening:
            if servo.id in _addressed(packet):
                servo.hear(now)
        answers = self._answers(packet, listening)
        if self.torque_since is None and any(servo.torque for servo in self.servos):
            self.torque_since = now
        answers = self._until_silence(packet, answers, now)
        in_turn = packet.instruction in (packets.SYNC_READ, packets.BULK_READ)
        return [self._send(servo, answer, now, in_turn) for servo, answer in self._on_the_line(answers)]

    def _on_the_line(self, answers: list[tuple[EmulatedServo, bytes]]) -> list[tuple[EmulatedServo, bytes]]:
        """Servos with one ID answer at once."""
        by_id: dict[int, list[tuple[EmulatedServo, bytes]]] = {}
        for servo, answer in answers:
            by_id.setdefault(servo.id, []).append((servo, answer))
        return [
            (group[0][0], group[0][1] if len(group) == 1 else overlapped([a for _, a in group], self._random))
            for group in by_id.values()
        ]

    def _until_silence(
        self, packet: packets.Packet, answers: list[tuple[EmulatedServo, bytes]], now: float
    ) -> list[tuple[EmulatedServo, bytes]]:
        """In a sync or bulk read each servo waits for the answer before its own: one silent servo silences the rest."""
        silent = [self._has("silent", servo, now) for servo, _ in answers]
        if packet.instruction in (packets.SYNC_READ, packets.BULK_READ) and any(silent):
            return answers[: silent.index(True)]
        return [answer for answer, is_silent in zip(answers, silent, strict=True) if not is_silent]

    def _answers(self, packet: packets.Packet, servos: list[EmulatedServo]) -> list[tuple[EmulatedServo, bytes]]:
        by_id: Servos = {}
        for servo in servos:
            by_id.setdefault(servo.id, []).append(servo)
        parameters = packet.parameters
        if packet.instruction == packets.STATUS:
            return []
        if packet.instruction in (packets.SYNC_READ, packets.BULK_READ):
            return self._read_many(packet, by_id)
        if packet.instruction == packets.SYNC_WRITE:
            self._sync_write(parameters, by_id)
            return []
        if packet.instruction == packets.BULK_WRITE:
            self._bulk_write(parameters, by_id)
            return []
        if packet.id == packets.BROADCAST:
            answers = [(servo, servo.execute(packet)) for servo in sorted(servos, key=lambda servo: servo.id)]
            wanted = answers if packet.instruction == packets.PING else []
        else:
            wanted = [(servo, servo.execute(packet)) for servo in by_id.get(packet.id, [])]
        return [(servo, answer) for servo, answer in wanted if answer is not None]

    def _read_many(self, packet: packets.Packet, by_id: Servos) -> list[tuple[EmulatedServo, bytes]]:
        """Servos answer in the order asked; one that is missing silences those behind it, which wait for its answer."""
        answers = []
        for servo_id, address, size in _questions(packet):
            asked = [servo for servo in by_id.get(servo_id, []) if servo.table["status_return_level"]]
            if not asked:
                break
            answers += [(servo, servo.read_status(address, size)) for servo in asked]
        return answers

    def _sync_write(self, parameters: bytes, by_id: Servos) -> None:
        address, size = int.from_bytes(parameters[:2], "little"), int.from_bytes(parameters[2:4], "little")
        body = parameters[4:]
        if size == 0 or len(body) % (size + 1):
            return
        for start in range(0, len(body), size + 1):
            for servo in by_id.get(body[start], []):
                servo.write(address, body[start + 1 : start + 1 + size])

    def _bulk_write(self, parameters: bytes, by_id: Servos) -> None:
        while len(parameters) >= 5:
            servo_id = parameters[0]
            address, size = int.from_bytes(parameters[1:3], "little"), int.from_bytes(parameters[3:5], "little")
            data, parameters = parameters[5 : 5 + size], parameters[5 + size :]
            for servo in by_id.get(servo_id, []) if len(data) == size and size else []:
                servo.write(address, data)

    def _send(self, servo: EmulatedServo, answer: bytes, now: float, in_turn: bool) -> Reply:
        """`in_turn`: the servos behind this one wait for its answer, so a delay is theirs too."""
        late = 0.0
        for fault in self.faults:
            if fault.servo not in (None, servo.id) or not fault.active(self.elapsed(now)):
                continue
            if fault.kind == "delay":
                late += fault.value
            hit = fault.kind in ("crc", "noise") and self._random.random() < fault.value
            if hit:
                place = len(answer) - 1 if fault.kind == "crc" else self._random.randrange(len(answer))
                answer = answer[:place] + bytes([answer[place] ^ self._random.randrange(1, 256)]) + answer[place + 1 :]
        self._free_at = max(self._free_at, now) + servo.table["return_delay_time"] * 2e-6 + len(answer) * self._byte_s
        reply = Reply(self._free_at + late, answer)
        if in_turn:
            self._free_at = reply.due
        return reply

    def _has(self, kind: str, servo: EmulatedServo, now: float) -> bool:
        return any(f.kind == kind and f.servo == servo.id and f.active(self.elapsed(now)) for f in self.faults)

    def _apply(self, fault: Fault) -> None:
        for servo in self.servos:
            if fault.kind == "overheat" and servo.id == fault.servo:
                servo.temperature = round(fault.value)
            if fault.kind == "reset" and servo.id == fault.servo and fault not in self._spent:
                self._spent.add(fault)
                servo.reset()
            if fault.kind == "stuck" and servo.id == fault.servo:
                servo.motion.fastest_rpm = fault.value
            if fault.kind == "voltage":
                servo.supply_voltage = fault.value


def _addressed(packet: packets.Packet) -> Container[int]:
    """The servos that a packet speaks to: these are the ones whose watchdogs it feeds."""
    data = packet.parameters
    if packet.instruction in (packets.SYNC_READ, packets.BULK_READ):
        return {servo_id for servo_id, _, _ in _questions(packet)}
    if packet.instruction == packets.SYNC_WRITE:
        return set(data[4 :: int.from_bytes(data[2:4], "little") + 1])
    return range(256) if packet.id == packets.BROADCAST else (packet.id,)


def _questions(packet: packets.Packet) -> list[tuple[int, int, int]]:
    """(servo ID, address, size) of each servo that a sync or bulk read asks."""
    data = packet.parameters
    if packet.instruction == packets.SYNC_READ:
        address, size = int.from_bytes(data[:2], "little"), int.from_bytes(data[2:4], "little")
        return [(servo_id, address, size) for servo_id in data[4:]]
    chunks = [data[start : start + 5] for start in range(0, len(data) - len(data) % 5, 5)]
    return [(c[0], int.from_bytes(c[1:3], "little"), int.from_bytes(c[3:5], "little")) for c in chunks]
