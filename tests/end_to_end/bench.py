"""A bench for end-to-end tests: gyrobenchd on the virtual stand in a folder of its own, with its own LCM port."""
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("GYROBENCH_BIN", ROOT / "build/dev/bin"))
DEADLINE_S = 120 * int(os.environ.get("GYROBENCH_SLOWNESS", "1"))


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def can_isolate_network():
    return shutil.which("unshare") is not None and subprocess.run(
        ["unshare", "-Urn", "true"], capture_output=True).returncode == 0


def refuse_findings(output):
    """A finding of a sanitizer fails the test, whatever the program's exit status means to it."""
    if "Sanitizer" in output or "runtime error:" in output:
        raise AssertionError(output)


def ask_socket(control_socket, method, path, body=b"", timeout_s=DEADLINE_S):
    """One request, byte by byte as given. Returns status and answer; None where it was closed without one."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.settimeout(timeout_s)
        connection.connect(str(control_socket))
        connection.sendall(method + b" " + path + b" HTTP/1.1\r\nHost: bench\r\nConnection: close\r\n"
                           + f"Content-Length: {len(body)}\r\n\r\n".encode() + body)
        reply = b""
        while part := connection.recv(65536):
            reply += part
    if not reply:
        return None
    head, _, text = reply.partition(b"\r\n\r\n")
    return int(head.split()[1]), json.loads(text.decode("utf-8", "strict"))


class Bench:
    """Use as a context manager: starts the daemon, and ends it by its process id.

    extra: further TOML for the stand file. scenario: text of a scenario of the test's own, with {root} for
    the source tree. before_start: called in the daemon's process before it starts. isolate_network: the
    daemon gets a network without any route, where the machine permits (then `isolated` is true). procedures:
    name to Lua source of procedures of the test's own.
    """

    def __init__(self, base="virtual.toml", extra="", extra_lcm="", scenario=None, before_start=None,
                 isolate_network=False, start=True, procedures=None):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="gyrobench-"))
        self.port = free_udp_port()
        self.records = self.folder / "records"
        self.config = self.folder / "stand.toml"
        if scenario:
            (self.folder / "scenario.toml").write_text(scenario.replace("{root}", str(ROOT)))
            virtual = f'[virtual]\nscenario = "{self.folder}/scenario.toml"\n'
            extra = extra.replace("[virtual]\n", virtual) if "[virtual]\n" in extra else extra + virtual
        self.procedures = self.folder / "procedures"
        own = ""
        if procedures is not None:
            self.procedures.mkdir()
            for name, source in procedures.items():
                (self.procedures / f"{name}.lua").write_text(source)
            own = f'procedures = ["{self.procedures}", "{ROOT}/procedures"]\n'
        self.config.write_text(
            f'include = "{ROOT}/config/{base}"\n{own}'
            f'records = "{self.records}"\ncontrol_socket = "{self.folder}/control.sock"\n'
            f'[lcm]\nurl = "udpm://239.255.76.67:{self.port}?ttl=0"\n{extra_lcm}{extra}')
        self.before_start = before_start
        self.isolated = isolate_network and can_isolate_network()
        self.start_daemon = start
        self.daemon = None

    def __enter__(self):
        if self.start_daemon:
            self.start()
        return self

    def start(self):
        prefix = ["unshare", "-Urn"] if self.isolated else []
        with open(self.folder / "daemon.log", "w") as log:
            self.daemon = subprocess.Popen([*prefix, BIN / "gyrobenchd", "--config", self.config],
                                           stdout=log, stderr=log, preexec_fn=self.before_start)
        # The control socket answers once the daemon is ready; each try is a process, so no busy loop.
        while self.run("status").returncode != 0:
            if self.daemon.poll() is not None:
                raise RuntimeError("gyrobenchd ended: " + self.daemon_log())

    def daemon_log(self):
        return (self.folder / "daemon.log").read_text()

    def __exit__(self, *_):
        self.stop()
        log = self.daemon_log() if self.daemon else ""
        shutil.rmtree(self.folder)
        refuse_findings(log)

    def stop(self):
        if self.daemon and self.daemon.poll() is None:
            self.daemon.terminate()
            self.daemon.wait(DEADLINE_S)

    def run(self, *arguments, **options):
        """Runs `gyrobench` and returns the finished process."""
        done = subprocess.run([BIN / "gyrobench", *map(str, arguments)],
                              env={**os.environ, "GYROBENCH_CONFIG": str(self.config), "NO_COLOR": "1"},
                              stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=DEADLINE_S, **options)
        refuse_findings(done.stderr)
        return done

    def json(self, *arguments):
        done = self.run(*arguments, "--json")
        if done.returncode != 0:
            raise RuntimeError(f"gyrobench {' '.join(map(str, arguments))}: {done.stderr}{done.stdout}")
        return json.loads(done.stdout)

    def ask(self, method, path, body=b"", timeout_s=DEADLINE_S):
        """One request to the control socket, byte by byte as given. Returns status and answer; None where the daemon
        closed without one."""
        return ask_socket(self.folder / "control.sock", method, path, body, timeout_s)

    def status(self):
        return self.ask(b"GET", b"/v1/status")[1]

    def newest_record(self):
        return max(self.records.iterdir(), key=lambda folder: folder.name)


def have_multicast():
    """Whether a datagram to LCM's group comes back to this machine."""
    port = free_udp_port()
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver, \
                socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            receiver.bind(("", port))
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                                socket.inet_aton("239.255.76.67") + socket.inet_aton("0.0.0.0"))
            receiver.settimeout(1)
            sender.sendto(b"?", ("239.255.76.67", port))
            receiver.recv(16)
            return True
    except OSError:
        return False


if not (BIN / "gyrobenchd").exists():
    sys.exit(f"no gyrobenchd in {BIN}: build first, or set GYROBENCH_BIN")
