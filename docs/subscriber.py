"""Prints every result of the bench: docs/subscribe.md."""
import socket, sys
from gyrobench import bias_result_t, scale_result_t

types = {b"GYROBENCH_BIAS_RESULT": bias_result_t, b"GYROBENCH_SCALE_RESULT": scale_result_t}
group, port = "239.255.76.67", int(sys.argv[1]) if len(sys.argv) > 1 else 7667
udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
udp.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2 << 20)
udp.bind((group, port))
udp.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group) + bytes(4))
print("listening", flush=True)
while True:
    packet = udp.recv(65536)  # "LC02", packet number, channel, 0, message
    channel, _, message = packet[8:].partition(b"\0")
    if packet[:4] == b"LC02" and channel in types:
        result = types[channel].decode(message)
        print(channel.decode(), {name: getattr(result, name) for name in result.__slots__}, flush=True)
