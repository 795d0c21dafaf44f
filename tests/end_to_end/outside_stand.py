"""The virtual stand as a process of its own, which goes on moving when a daemon dies; and a hand on its wires."""
import os
import select
import struct
import subprocess
import termios
import tty

from bench import BIN, ROOT, Bench, DEADLINE_S

RELAYS, INNER_DRIVE, HEATER = 31, 3, 1
ENABLE, STATUS, POSITION, PATH = 0x000F, 0x1003, 0x602A, 0x6200  # config/devices/leadshine-rs.toml
RUNNING_BIT, PULSES_PER_TABLE_TURN = 2, 400_000


def checksum(frame):
    """CRC-16 of Modbus."""
    crc = 0xFFFF
    for byte in frame:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return struct.pack("<H", crc)


class OutsideStand(Bench):
    """A bench on a stand with relays, in real time. `stand` is its process; the daemon starts with start().

    program: what serves the stand. stand_scenario: text of its scenario, with {root} for the source tree.
    """

    def __init__(self, program=BIN / "gyrobench-stand", stand_scenario=None, **options):
        super().__init__(base="stand.toml", start=False, **options)
        self.program = program
        self.stand_scenario = ROOT / "config/scenarios/typical.toml"
        if stand_scenario:
            self.stand_scenario = self.folder / "stand-scenario.toml"
            self.stand_scenario.write_text(stand_scenario.replace("{root}", str(ROOT)))
        text = self.config.read_text()
        buses = "".join(f'[bus.{name}]\ndevice = "{self.folder}/bus-{name}"\n' for name in "ab")
        relays = f'[relays]\nbus = "a"\nunit = {RELAYS}\nmap = "{ROOT}/config/devices/relay-unit.toml"\nfan = 0\nheater = 1\n'
        self.config.write_text(text + buses + relays)
        self.stand = None

    def __enter__(self):
        self.stand = subprocess.Popen(
            [self.program, "--config", self.config, "--link", self.folder, "--scenario", self.stand_scenario],
            stdout=subprocess.PIPE, text=True)
        for _ in "ab":
            self.stand.stdout.readline()
        return super().__enter__()

    def __exit__(self, *arguments):
        try:
            self.stop()
        finally:
            self.stand.terminate()
            self.stand.wait(DEADLINE_S)
            self.stand.stdout.close()
        super().__exit__(*arguments)

    def transact(self, unit, function, payload, reply_bytes):
        """One Modbus request on bus a; only while no daemon has the line."""
        line = os.open(self.folder / "bus-a", os.O_RDWR | os.O_NOCTTY)
        try:
            tty.setraw(line)
            termios.tcflush(line, termios.TCIOFLUSH)
            frame = bytes([unit, function]) + payload
            os.write(line, frame + checksum(frame))
            reply = b""
            while len(reply) < reply_bytes:
                if not select.select([line], [], [], DEADLINE_S)[0]:
                    raise RuntimeError(f"no reply of unit {unit}")
                reply += os.read(line, 256)
        finally:
            os.close(line)
        if reply[1] != function or reply[-2:] != checksum(reply[:-2]):
            raise RuntimeError(f"unit {unit} answers {reply.hex()}")
        return reply[2:-2]

    def registers(self, unit, address, count):
        data = self.transact(unit, 3, struct.pack(">HH", address, count), 5 + 2 * count)
        return struct.unpack(f">{count}H", data[1:])

    def inner_is_moving(self):
        return bool(self.registers(INNER_DRIVE, STATUS, 1)[0] >> RUNNING_BIT & 1)

    def inner_deg(self):
        high, low = self.registers(INNER_DRIVE, POSITION, 2)
        return struct.unpack(">i", struct.pack(">HH", high, low))[0] / PULSES_PER_TABLE_TURN * 360

    def move_inner(self, angle_deg, rpm):
        """What a daemon that is gone by now had commanded."""
        self.transact(INNER_DRIVE, 6, struct.pack(">HH", ENABLE, 1), 8)
        pulses = struct.unpack(">HH", struct.pack(">i", round(angle_deg / 360 * PULSES_PER_TABLE_TURN)))
        words = (0x0041, *pulses, rpm, 100, 100, 0, 0x0010)
        self.transact(INNER_DRIVE, 16, struct.pack(">HHB8H", PATH, 8, 16, *words), 8)

    def heat(self):
        self.transact(RELAYS, 5, struct.pack(">HH", HEATER, 0xFF00), 8)

    def heats(self):
        return bool(self.transact(RELAYS, 1, struct.pack(">HH", HEATER, 1), 6)[1] & 1)
