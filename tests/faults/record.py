"""A record as it lies on disk, read without the product: events of LCM's log, blocks of the gyro's samples."""
import struct

SYNC = 0xEDA1DA01


class Broken(Exception):
    """What is wrong with a record."""


def events(path):
    """(channel, bytes) of each event, in order."""
    data = path.read_bytes()
    end = 0
    for channel, message, end in events_with_ends(data):
        yield channel, message
    if end < len(data):
        raise Broken(f"no whole event at byte {end} of {len(data)}")


def whole_events(data):
    """(channel, bytes) of each event at the begin of a log up to the first that is cut."""
    for channel, message, _ in events_with_ends(data):
        yield channel, message


def events_with_ends(data):
    """The same, with the byte behind each."""
    at = 0
    while len(data) - at >= 28:
        sync, _, _, channel_size, size = struct.unpack_from(">IqqII", data, at)
        begin = at + 28 + channel_size
        if sync != SYNC or begin + size > len(data):
            return
        at = begin + size
        yield data[begin - channel_size:begin].decode(), data[begin:at], at


def text(message, at):
    (size,) = struct.unpack_from(">i", message, at)
    return message[at + 4:at + 3 + size].decode(), at + 4 + size


class Block:
    """One gyro_t."""

    def __init__(self, message):
        (self.utime,) = struct.unpack_from(">q", message, 8)
        self.run_id, at = text(message, 16)
        layout = ">qqdiqddiq"
        self.seq, _, _, self.boot_count, self.missed, _, _, self.n, self.first = struct.unpack_from(layout, message, at)
        self.times_at = at + struct.calcsize(layout)

    def times(self, message):
        """Of its samples, host clock, microseconds."""
        return struct.unpack_from(f">{self.n}q", message, self.times_at)


class Run:
    """One run_t: `event` and `text`."""
    SUSPEND = 10

    def __init__(self, message):
        _, at = text(message, 16)
        self.event = struct.unpack_from(">qb", message, at)[1]


def read(path):
    """Blocks of the gyro and events of the run."""
    blocks, course = [], []
    for channel, message in events(path):
        if channel.endswith("_GYRO"):
            blocks.append(Block(message))
        if channel.endswith("_RUN"):
            course.append(Run(message))
    return blocks, course


def unmarked_gaps(blocks):
    """Places where samples are missing, or messages, and the record does not say so."""
    found, settled = [], True
    lost = said = 0  # since the first block of this start of the unit
    # What that block misses may be before its first sample, where it is not asked for, or behind it.
    spare = blocks[0].missed if blocks else 0
    for before, block in zip(blocks, blocks[1:]):
        if block.seq != before.seq + 1:
            found.append(f"message {before.seq + 1} of the gyro is missing")
        if block.boot_count != before.boot_count or (not settled and before.n == 0):
            # What a unit that restarted has sampled before it was set up again is not asked for.
            settled, lost, said, spare = block.n > 0, 0, 0, block.missed
            continue
        settled = True
        lost += block.first - (before.first + before.n)
        # What a block misses may be before its first sample or behind it.
        most = said + spare + block.missed
        if not said <= lost <= most:
            found.append(f"{lost} samples before sample {block.first} are missing, said are {said} to {most}")
            said = lost
        said += block.missed
    return found
